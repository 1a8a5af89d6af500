//! The binary format between worker and coordinator: one module, so that the
//! codec behind it can be changed in one place.
//!
//! Layout of a message: 8 bytes magic `SHRWATER`, u16 little-endian
//! [`PROTOCOL_VERSION`], 32 bytes blake3 of the payload, payload. The payload is
//! bincode with fixed-width integers. Bodies come from other machines, so the
//! decoder is limited in bytes, refuses trailing bytes and checks the hash.

mod before;

use crate::film::{TileFilm, TileSums};
use crate::job::JobId;
use crate::plan::Run;
use serde::{Deserialize, Serialize, de::DeserializeOwned};

/// Version of everything a worker and a coordinator say to each other.
/// 1: first version. 2: sums and films carry a histogram of brightness; the
/// coordinator still reads what it stored in version 1.
pub const PROTOCOL_VERSION: u16 = 2;
/// Content type of a message.
pub const CONTENT_TYPE: &str = "application/vnd.shearwater.v1+bincode";
/// Largest message: a 64 x 64 tile with features is 480 KiB, a merged film of
/// i128 sums 925 KiB.
pub const MESSAGE_BYTES_MAX: usize = 2 << 20;

const MAGIC: &[u8; 8] = b"SHRWATER";
const HEADER_BYTES: usize = 8 + 2 + 32;

/// A body that is no message of ours.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum WireError {
    /// Longer than any message.
    #[error("message of {0} bytes: the limit is {MESSAGE_BYTES_MAX}")]
    TooLong(usize),
    /// Does not begin as our messages do.
    #[error("not a Shearwater message: it must begin with SHRWATER and a version")]
    Magic,
    /// Another protocol.
    #[error(
        "protocol version {0}: this build speaks {PROTOCOL_VERSION}; install the same version on both sides"
    )]
    Version(u16),
    /// Damaged on the way.
    #[error("payload hash does not match: the body was damaged on the way; send it again")]
    Hash,
    /// Payload that is not the expected type.
    #[error("payload cannot be read: {0}")]
    Payload(String),
    /// Bytes behind the payload.
    #[error("{0} bytes behind the message")]
    Trailing(usize),
}

/// What a worker delivers for one run.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct PartUpload {
    /// Job.
    pub job: JobId,
    /// The run whose sums these are.
    pub run: Run,
    /// Lease under which it was rendered.
    pub lease: i64,
    /// Worker, as in its lease requests.
    pub worker: String,
    /// Numeric build of the worker's tracer.
    pub build: String,
    /// Seconds of one core that it took, in microseconds.
    pub core_us: u64,
    /// The sums.
    pub sums: TileSums,
}

fn config() -> impl bincode::config::Config {
    bincode::config::standard()
        .with_little_endian()
        .with_fixed_int_encoding()
        .with_limit::<MESSAGE_BYTES_MAX>()
}

fn encode<T: Serialize>(value: &T) -> Result<Vec<u8>, WireError> {
    let payload = bincode::serde::encode_to_vec(value, config())
        .map_err(|e| WireError::Payload(e.to_string()))?;
    let mut message = Vec::with_capacity(HEADER_BYTES + payload.len());
    message.extend_from_slice(MAGIC);
    message.extend_from_slice(&PROTOCOL_VERSION.to_le_bytes());
    message.extend_from_slice(blake3::hash(&payload).as_bytes());
    message.extend_from_slice(&payload);
    if message.len() > MESSAGE_BYTES_MAX {
        return Err(WireError::TooLong(message.len()));
    }
    Ok(message)
}

fn decode<T: DeserializeOwned>(body: &[u8]) -> Result<T, WireError> {
    let (version, payload) = open(body)?;
    if version != PROTOCOL_VERSION {
        return Err(WireError::Version(version));
    }
    decode_payload(payload)
}

/// What was stored in this version or in the one before.
fn decode_stored<T, Old>(body: &[u8]) -> Result<T, WireError>
where
    T: DeserializeOwned + From<Old>,
    Old: DeserializeOwned,
{
    match open(body)? {
        (PROTOCOL_VERSION, payload) => decode_payload(payload),
        (1, payload) => decode_payload::<Old>(payload).map(T::from),
        (other, _) => Err(WireError::Version(other)),
    }
}

/// Version and payload of a message.
fn open(body: &[u8]) -> Result<(u16, &[u8]), WireError> {
    if body.len() > MESSAGE_BYTES_MAX {
        return Err(WireError::TooLong(body.len()));
    }
    if body.len() < HEADER_BYTES || &body[..8] != MAGIC {
        return Err(WireError::Magic);
    }
    let version = u16::from_le_bytes([body[8], body[9]]);
    let payload = &body[HEADER_BYTES..];
    // A later version may hash otherwise: its number is said, not a damage.
    if version <= PROTOCOL_VERSION && blake3::hash(payload).as_bytes() != &body[10..HEADER_BYTES] {
        return Err(WireError::Hash);
    }
    Ok((version, payload))
}

fn decode_payload<T: DeserializeOwned>(payload: &[u8]) -> Result<T, WireError> {
    let (value, used) = bincode::serde::decode_from_slice(payload, config())
        .map_err(|e| WireError::Payload(e.to_string()))?;
    if used != payload.len() {
        return Err(WireError::Trailing(payload.len() - used));
    }
    Ok(value)
}

/// One part as a message.
///
/// # Errors
/// Longer than [`MESSAGE_BYTES_MAX`].
pub fn encode_part(part: &PartUpload) -> Result<Vec<u8>, WireError> {
    encode(part)
}

/// A message as one part. The shape against the job's plan is checked by
/// [`TileSums::check`].
///
/// # Errors
/// See [`WireError`].
pub fn decode_part(body: &[u8]) -> Result<PartUpload, WireError> {
    decode(body)
}

/// Sums of one run, as the coordinator keeps them in an object.
///
/// # Errors
/// Longer than [`MESSAGE_BYTES_MAX`].
pub fn encode_sums(sums: &TileSums) -> Result<Vec<u8>, WireError> {
    encode(sums)
}

/// An object as the sums of one run.
///
/// # Errors
/// See [`WireError`].
pub fn decode_sums(body: &[u8]) -> Result<TileSums, WireError> {
    decode_stored::<_, before::TileSums1>(body)
}

/// The merged film of a tile, as the coordinator keeps it in an object.
///
/// # Errors
/// Longer than [`MESSAGE_BYTES_MAX`].
pub fn encode_film(film: &TileFilm) -> Result<Vec<u8>, WireError> {
    encode(film)
}

/// An object as the merged film of a tile.
///
/// # Errors
/// See [`WireError`].
pub fn decode_film(body: &[u8]) -> Result<TileFilm, WireError> {
    decode_stored::<_, before::TileFilm1>(body)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn part() -> PartUpload {
        let mut sums = TileSums::zero(64 * 64, &(0..64));
        for (i, v) in sums.radiance[0].iter_mut().enumerate() {
            *v = i as i64 * 1_000_003;
        }
        PartUpload {
            job: JobId(7),
            run: Run {
                frame: 0,
                tile: 3,
                block0: 1,
                block1: 2,
            },
            lease: 12,
            worker: "w".into(),
            build: "b".into(),
            core_us: 500_000,
            sums,
        }
    }

    #[test]
    fn round_trips() {
        let part = part();
        assert_eq!(
            decode_part(&encode_part(&part).expect("encode")),
            Ok(part.clone())
        );
        let mut film = TileFilm::zero(64 * 64);
        film.add(&part.sums).expect("fits");
        film.radiance[0][0] = i128::MAX;
        assert_eq!(decode_film(&encode_film(&film).expect("encode")), Ok(film));
        assert_eq!(
            decode_sums(&encode_sums(&part.sums).expect("encode")),
            Ok(part.sums)
        );
    }

    #[test]
    fn every_kind_of_damage_is_named() {
        let good = encode_part(&part()).expect("encode");
        assert_eq!(decode_part(&[]), Err(WireError::Magic));
        assert_eq!(decode_part(b"GET / HTTP/1.1"), Err(WireError::Magic));
        assert_eq!(
            decode_part(&vec![0; MESSAGE_BYTES_MAX + 1]),
            Err(WireError::TooLong(MESSAGE_BYTES_MAX + 1))
        );
        let mut other = good.clone();
        other[8] = 9;
        assert_eq!(decode_part(&other), Err(WireError::Version(9)));
        for at in [10, 60, good.len() - 1] {
            let mut flipped = good.clone();
            flipped[at] ^= 1;
            assert_eq!(decode_part(&flipped), Err(WireError::Hash), "{at}");
        }
        assert_eq!(decode_part(&good[..good.len() - 1]), Err(WireError::Hash));
    }

    // What version 1 wrote ends where the histogram begins.
    #[test]
    fn films_and_sums_of_version_1_are_read() {
        const BINS: usize = 8 + crate::film::BRIGHTNESS_BINS * (8 + 16);
        let first = |message: Vec<u8>, less: usize| {
            let mut body = sealed(&message[HEADER_BYTES..message.len() - less]);
            body[8..10].copy_from_slice(&1u16.to_le_bytes());
            body
        };
        let mut sums = part().sums;
        let mut film = TileFilm::zero(64 * 64);
        film.add(&sums).expect("fits");
        let old_sums = first(encode_sums(&sums).expect("encode"), BINS);
        let old_film = first(encode_film(&film).expect("encode"), BINS);
        sums.brightness = crate::film::Brightness::default();
        film.brightness = crate::film::Brightness::default();
        assert_eq!(decode_sums(&old_sums), Ok(sums));
        assert_eq!(decode_film(&old_film), Ok(film.clone()));
        // A worker of version 1 is told so.
        assert_eq!(decode_part(&old_sums), Err(WireError::Version(1)));
        let mut damaged = old_film;
        damaged[100] ^= 1;
        assert_eq!(decode_film(&damaged), Err(WireError::Hash));
    }

    // A liar can hash whatever it likes: lengths must not be believed.
    fn sealed(payload: &[u8]) -> Vec<u8> {
        let mut body = MAGIC.to_vec();
        body.extend_from_slice(&PROTOCOL_VERSION.to_le_bytes());
        body.extend_from_slice(blake3::hash(payload).as_bytes());
        body.extend_from_slice(payload);
        body
    }

    #[test]
    fn sealed_nonsense_is_an_error_not_a_panic() {
        let good = encode_part(&part()).expect("encode");
        let mut longer = good[HEADER_BYTES..].to_vec();
        longer.push(0);
        assert_eq!(decode_part(&sealed(&longer)), Err(WireError::Trailing(1)));
        let mut lengths = good[HEADER_BYTES..].to_vec();
        lengths[32..40].fill(0xff);
        assert!(matches!(
            decode_part(&sealed(&lengths)),
            Err(WireError::Payload(_))
        ));
    }

    proptest! {
        #[test]
        fn random_payloads_never_panic(bytes in proptest::collection::vec(any::<u8>(), 0..512)) {
            let _ = decode_part(&bytes);
            let _ = decode_part(&sealed(&bytes));
            let _ = decode_film(&sealed(&bytes));
        }
    }
}
