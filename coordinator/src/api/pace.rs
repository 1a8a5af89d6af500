//! Long bodies: as long as they like, but not as slow.

use super::problem::ApiError;
use axum::body::{BodyDataStream, Bytes};
use futures_util::StreamExt;
use std::time::Duration;
use tokio::time::Instant;

/// Time of waiting for the client in which [`WINDOW_BYTES_MIN`] must arrive.
const WINDOW: Duration = Duration::from_secs(30);
/// Least bytes of a window that is not the last: 4 KiB/s. The largest asset takes
/// six days over such a line; a byte a second would hold a place for decades.
const WINDOW_BYTES_MIN: u64 = 120 << 10;

/// The pieces of a body. Only time that the client is waited for counts, not
/// what the store takes.
pub(crate) struct Paced {
    body: BodyDataStream,
    window: Duration,
    waited: Duration,
    bytes: u64,
}

impl Paced {
    /// The pieces of `body`.
    pub(crate) const fn new(body: BodyDataStream) -> Self {
        Self::within(body, WINDOW)
    }

    const fn within(body: BodyDataStream, window: Duration) -> Self {
        Self {
            body,
            window,
            waited: Duration::ZERO,
            bytes: 0,
        }
    }

    /// The next piece; `None` at the end.
    pub(crate) async fn next(&mut self) -> Result<Option<Bytes>, ApiError> {
        loop {
            let began = Instant::now();
            let left = self.window.saturating_sub(self.waited);
            match tokio::time::timeout(left, self.body.next()).await {
                Ok(Some(Ok(piece))) => {
                    self.waited += began.elapsed();
                    self.bytes = self.bytes.saturating_add(piece.len() as u64);
                    return Ok(Some(piece));
                }
                Ok(Some(Err(_))) => {
                    return Err(ApiError::BadRequest("the body broke off".into()));
                }
                Ok(None) => return Ok(None),
                Err(_) if self.bytes >= WINDOW_BYTES_MIN => {
                    self.waited = Duration::ZERO;
                    self.bytes = 0;
                }
                Err(_) => return Err(ApiError::Timeout),
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use axum::body::Body;
    use futures_util::stream;
    use std::convert::Infallible;

    const WINDOW_MS: u64 = 200;

    /// `pieces` of `size` bytes, one every `pause_ms`.
    async fn arrives(pieces: usize, size: usize, pause_ms: u64) -> Result<u64, ApiError> {
        let pause = Duration::from_millis(pause_ms);
        let pieces = stream::iter(0..pieces).then(move |_| async move {
            tokio::time::sleep(pause).await;
            Ok::<_, Infallible>(Bytes::from(vec![0; size]))
        });
        let body = Body::from_stream(pieces).into_data_stream();
        let mut paced = Paced::within(body, Duration::from_millis(WINDOW_MS));
        let mut size = 0;
        while let Some(piece) = paced.next().await? {
            size += piece.len() as u64;
        }
        Ok(size)
    }

    #[tokio::test]
    async fn a_dripping_body_is_too_slow_and_a_modem_is_not() {
        let dripping = arrives(1_000, 1, 10).await;
        assert!(matches!(dripping, Err(ApiError::Timeout)), "{dripping:?}");
        // Four times the least, for three windows: a busy machine may be slow itself.
        let modem = arrives(24, 64 << 10, WINDOW_MS / 8).await;
        assert_eq!(modem.expect("in time"), 24 * (64 << 10));
        let silent = arrives(2, 1 << 10, 2 * WINDOW_MS).await;
        assert!(matches!(silent, Err(ApiError::Timeout)), "{silent:?}");
        // Short of the least, but over before the window is.
        assert_eq!(arrives(3, 1, 10).await.expect("in time"), 3);
    }
}
