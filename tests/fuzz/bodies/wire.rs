//! Messages of the worker protocol, as anybody may send them.

use shearwater_shared::hash::ContentHash;
use shearwater_shared::plan::TileRect;
use shearwater_shared::wire;

/// First bytes of a message, as the format is described in [`wire`].
const MAGIC: &[u8] = b"SHRWATER";

/// The payload as a message with a right hash: a liar can hash whatever it likes.
pub(super) fn sealed(version: u16, payload: &[u8]) -> Vec<u8> {
    let mut body = MAGIC.to_vec();
    body.extend_from_slice(&version.to_le_bytes());
    body.extend_from_slice(ContentHash::of(payload).as_bytes());
    body.extend_from_slice(payload);
    body
}

/// The first byte says whether the rest is a whole message or a payload, and of
/// which version.
pub fn wire(data: &[u8]) {
    let Some((&kind, rest)) = data.split_first() else {
        return;
    };
    let body = match kind % 4 {
        0 => rest.to_vec(),
        1 => sealed(1, rest),
        2 => sealed(kind.into(), rest),
        _ => sealed(wire::PROTOCOL_VERSION, rest),
    };
    if let Ok(part) = wire::decode_part(&body) {
        // One message for one value: nothing is read that is not written.
        assert_eq!(wire::encode_part(&part).as_deref(), Ok(&*body));
        let rect = TileRect {
            x0: 0,
            y0: 0,
            width: (part.sums.radiance[0].len() / 3) as u32,
            height: 1,
        };
        let samples = 0..part.sums.samples_per_half;
        let _ = part.sums.check(&rect, &samples);
        let _ = part.sums.check(&rect, &(16..16 + samples.end.min(1 << 12)));
    }
    let is_now = body.get(8..10) == Some(&wire::PROTOCOL_VERSION.to_le_bytes());
    if let Ok(sums) = wire::decode_sums(&body) {
        let again = wire::encode_sums(&sums).expect("as long as it was");
        assert_eq!(wire::decode_sums(&again), Ok(sums));
        assert!(!is_now || again == body);
    }
    if let Ok(film) = wire::decode_film(&body) {
        let again = wire::encode_film(&film).expect("as long as it was");
        assert_eq!(wire::decode_film(&again), Ok(film));
        assert!(!is_now || again == body);
    }
}
