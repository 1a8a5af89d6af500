//! Memory of this process.

/// Largest resident size so far, in bytes; `None` where the system has no
/// `/proc`.
pub(crate) fn peak_bytes() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    parse(&status)
}

fn parse(status: &str) -> Option<u64> {
    let line = status
        .lines()
        .find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kib = line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok()?;
    kib.checked_mul(1024)
}

#[cfg(test)]
mod tests {
    #[test]
    fn reads_the_high_water_mark() {
        let status = "VmPeak:\t  999 kB\nVmHWM:\t    12 kB\nVmRSS:\t 5 kB\n";
        assert_eq!(super::parse(status), Some(12 * 1024));
        assert_eq!(super::parse("VmHWM: x kB"), None);
        assert_eq!(super::parse(""), None);
    }
}
