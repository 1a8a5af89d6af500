//! Stored films and sums, damaged in any way that the hash does not show: what
//! the coordinator does with them when it folds a tile and shows a picture.

use super::wire::sealed;
use shearwater_shared::film::{TileFilm, TileSums, join_errors, tile_error};
use shearwater_shared::wire;

/// Pixels of the tile that the objects are said to be of.
const PIXELS: usize = 4;
/// Its width.
const WIDTH: usize = 2;

/// Two bytes of length, a stored film of that many bytes, stored sums behind it.
/// The film's version is the highest bit of the length.
pub fn film(data: &[u8]) {
    let Some((head, rest)) = data.split_at_checked(2) else {
        return;
    };
    let head = u16::from_le_bytes([head[0], head[1]]);
    let (version, length) = (2 - (head >> 15), usize::from(head & 0x7fff));
    let (film, sums) = rest.split_at(length.min(rest.len()));
    let film = wire::decode_film(&sealed(version, film));
    let sums = wire::decode_sums(&sealed(version, sums));
    let mut film = film.unwrap_or_else(|_| TileFilm::zero(PIXELS));
    if film.check(PIXELS).is_err() {
        return;
    }
    show(&film);
    film.add_film(&TileFilm::zero(PIXELS))
        .expect("as many pixels");
    let sums = sums.unwrap_or_else(|_| TileSums::zero(PIXELS, &(0..2)));
    if film.add(&sums).is_ok() {
        show(&film);
    }
}

/// Everything that is read of a film.
fn show(film: &TileFilm) {
    assert_eq!(film.pixels(), PIXELS);
    for pixel in 0..PIXELS {
        for value in [
            film.half_mean(0, pixel),
            film.half_mean(1, pixel),
            film.mean(pixel),
        ] {
            assert!(value.iter().all(|v| v.is_finite()), "{value:?}");
        }
        assert!(film.feature_mean(pixel).iter().all(|v| v.is_finite()));
    }
    let error = tile_error(film, WIDTH);
    let _ = join_errors([(0, error)].into_iter())
        .map(|estimate| estimate.with_brightness(&film.brightness));
    let bytes = wire::encode_film(film).expect("no longer than a message");
    assert_eq!(wire::decode_film(&bytes).as_ref(), Ok(film));
}
