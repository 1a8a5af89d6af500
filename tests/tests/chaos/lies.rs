//! Workers that compute wrongly: their sums are changed on the way, and sealed again.

use axum::body::Bytes;
use shearwater_shared::wire;
use std::sync::{Arc, Mutex};

/// Those that lied, by their instances, and what they said. The nth adds n to a sum: no
/// two tell the same lie, since an audit believes what two say.
#[derive(Clone, Default)]
pub(crate) struct Liars(Arc<Mutex<Vec<String>>>);

impl Liars {
    /// A result with a wrong sum; what is no result stays as it is.
    pub(crate) fn lie(&self, body: Bytes) -> Bytes {
        let Ok(mut part) = wire::decode_part(&body) else {
            return body;
        };
        let mut liars = self.0.lock().expect("liars");
        let known = liars.iter().position(|liar| *liar == part.worker);
        let number = known.unwrap_or_else(|| {
            liars.push(part.worker.clone());
            liars.len() - 1
        });
        let wrong = number + 1;
        part.sums.radiance[0][0] += wrong as i64;
        // The histogram must agree, or the result would be refused.
        let bins = part.sums.brightness.bins.iter_mut();
        if let Some(bin) = bins.max_by_key(|bin| bin.samples) {
            bin.light += wrong as u128;
        }
        wire::encode_part(&part).map_or(body, Bytes::from)
    }

    /// All of them.
    pub(crate) fn all(&self) -> Vec<String> {
        self.0.lock().expect("liars").clone()
    }
}
