//! What a connection may cost before anybody knows whose it is.

use std::time::Duration;

/// Most connections at once: every waiter (10,000 lease polls and event
/// streams), results and uploads beside them. Further ones wait unaccepted.
const CONNECTIONS_MAX: usize = 16_384;
/// Files that the process keeps for the database, objects and its log, however
/// many connections come.
const FILES_KEPT: usize = 192;
/// Time for a whole request head to arrive, and longest rest of a connection
/// between two requests. Our clients close theirs sooner
/// (`pool_idle_timeout`), so that none of them sends into a closing one.
pub(super) const HEADER_TIMEOUT: Duration = Duration::from_secs(15);
/// Time for a TLS handshake: a few round trips, and a signature on a busy machine.
pub(super) const HANDSHAKE_TIMEOUT: Duration = Duration::from_secs(10);
/// Most headers of a request; ours have under ten, proxies add as many.
pub(super) const HEADERS_MAX: usize = 64;
/// Memory for what a connection has sent and nobody has read, and so the longest
/// head: 1 GiB if every connection fills it.
pub(super) const READ_BUFFER_BYTES: usize = 64 << 10;
/// Longest time in which the other side takes nothing of an answer. A phone in a
/// tunnel loses its picture and asks again.
pub(super) const WRITE_TIMEOUT: Duration = Duration::from_secs(30);
/// Beyond a shutdown's grace: dropping what was cut off.
pub(super) const END_TIMEOUT: Duration = Duration::from_secs(1);

/// Connections that this process can hold: an open file each, of which the
/// system gives out a number. 0 is never the answer.
pub(super) fn connections_max() -> usize {
    let files = std::fs::read_to_string("/proc/self/limits")
        .ok()
        .and_then(|text| open_files(&text));
    let most = files.map_or(CONNECTIONS_MAX, |files| {
        files.saturating_sub(FILES_KEPT).max(files / 2).max(1)
    });
    most.min(CONNECTIONS_MAX)
}

/// The soft limit of open files in the text of `/proc/self/limits`.
fn open_files(limits: &str) -> Option<usize> {
    let line = limits
        .lines()
        .find_map(|line| line.strip_prefix("Max open files"))?;
    line.split_whitespace().next()?.parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_limit_connections() {
        let text = "Limit   Soft Limit   Hard Limit   Units\n\
                    Max open files            1024                 524288               files\n";
        assert_eq!(open_files(text), Some(1024));
        assert_eq!(
            open_files("Max open files   unlimited unlimited files"),
            None
        );
        assert_eq!(open_files(""), None);
        assert!((1..=CONNECTIONS_MAX).contains(&connections_max()));
    }
}
