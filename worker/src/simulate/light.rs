//! Sums that nobody rendered, but that are right: each block has its own light, and
//! blocks add up however runs are cut, so that the film has one right value.

use super::dice::{self, Draw};
use shearwater_shared::film::{
    Brightness, FilmError, FilmHasher, TileFilm, TileSums, brightness_bin,
};
use shearwater_shared::hash::ContentHash;
use shearwater_shared::plan::{Plan, Run};

/// Fixed-point light of a sample, at most so many bits: a sixteenth of white.
const LIGHT_BITS: u32 = 20;

/// What a run of the simulated scene delivers; `None` when it is not of the plan.
/// Every sample of a half of a block has the same light in every pixel and channel.
pub(super) fn sums(plan: &Plan, run: &Run) -> Option<TileSums> {
    let pixels = plan.tile_rect(run.tile)?.pixels();
    let samples = plan.sample_range(run)?;
    let mut sums = TileSums::zero(pixels, &samples);
    let mut light = [0i64; 2];
    for block in run.block0..run.block1 {
        let one = Run {
            block0: block,
            block1: block + 1,
            ..*run
        };
        let samples = plan.sample_range(&one)?.len() as i64;
        for (half, light) in light.iter_mut().enumerate() {
            let sample = light_of(run, block, half);
            *light += sample * samples;
            count(
                &mut sums.brightness,
                3 * sample,
                samples as u64 * pixels as u64,
            );
        }
    }
    for (half, light) in sums.radiance.iter_mut().zip(light) {
        half.fill(light);
    }
    Some(sums)
}

fn light_of(run: &Run, block: u32, half: usize) -> i64 {
    let place = u64::from(run.tile) << 32 | u64::from(block);
    let bits = dice::bits(0, Draw::Light, [run.frame.into(), place, half as u64]);
    (bits >> (64 - LIGHT_BITS)) as i64
}

fn count(brightness: &mut Brightness, light: i64, samples: u64) {
    if let Some(bin) = brightness.bins.get_mut(brightness_bin(light)) {
        bin.samples += samples;
        bin.light += u128::from(samples) * light.unsigned_abs() as u128;
    }
}

/// The film hash that frame `frame` (the job's number) of a plan must have when
/// every unit of it was counted once.
///
/// # Errors
/// A tile is not of the plan, which cannot be.
pub fn film_hash(plan: &Plan, frame: u32) -> Result<ContentHash, FilmError> {
    let mut hasher = FilmHasher::new(*plan);
    let row = plan.tiles_x().max(1);
    for first in (0..plan.tiles()).step_by(row as usize) {
        let films = (first..first + row)
            .map(|tile| tile_film(plan, frame, tile))
            .collect::<Result<Vec<_>, _>>()?;
        hasher.add_band(&films.iter().collect::<Vec<_>>())?;
    }
    hasher.finish()
}

fn tile_film(plan: &Plan, frame: u32, tile: u32) -> Result<TileFilm, FilmError> {
    let missing = FilmError::Shape("a tile is not of the plan");
    let rect = plan.tile_rect(tile).ok_or_else(|| missing.clone())?;
    let mut film = TileFilm::zero(rect.pixels());
    // Block by block: a whole tile may be too long for one run.
    for block in 0..plan.blocks() {
        let run = Run {
            frame,
            tile,
            block0: block,
            block1: block + 1,
        };
        film.add(&sums(plan, &run).ok_or_else(|| missing.clone())?)?;
    }
    Ok(film)
}

#[cfg(test)]
mod tests {
    use super::*;
    use shearwater_shared::job::RenderSettings;
    use shearwater_shared::stop::Stop;

    fn plan(width: u32, height: u32, samples: u32) -> Plan {
        Plan::new(&RenderSettings {
            width,
            height,
            samples,
            seed: 0,
            frames: 3,
            first_frame: 0,
            stop: Stop::default(),
        })
    }

    #[test]
    fn a_coordinator_takes_the_sums_of_any_cut() {
        let plan = plan(100, 65, 1000);
        for tile in 0..plan.tiles() {
            for (block0, block1) in [(0, 1), (0, 8), (3, 5), (7, 8)] {
                let run = Run {
                    frame: 2,
                    tile,
                    block0,
                    block1,
                };
                let sums = sums(&plan, &run).expect("of the plan");
                let rect = plan.tile_rect(tile).expect("tile");
                let samples = plan.sample_range(&run).expect("samples");
                assert_eq!(sums.check(&rect, &samples), Ok(()), "{run:?}");
            }
        }
        let beyond = Run {
            frame: 0,
            tile: 0,
            block0: 7,
            block1: 9,
        };
        assert_eq!(sums(&plan, &beyond), None);
    }

    #[test]
    fn the_film_does_not_depend_on_the_cut_and_frames_differ() {
        let plan = plan(65, 1, 1024);
        let whole = film_hash(&plan, 1).expect("hash");
        let mut films = Vec::new();
        for tile in 0..plan.tiles() {
            let mut film = TileFilm::zero(plan.tile_rect(tile).expect("tile").pixels());
            for (block0, block1) in [(5, 8), (0, 2), (2, 5)] {
                let run = Run {
                    frame: 1,
                    tile,
                    block0,
                    block1,
                };
                film.add(&sums(&plan, &run).expect("sums")).expect("fits");
            }
            films.push(film);
        }
        let mut hasher = FilmHasher::new(plan);
        hasher
            .add_band(&films.iter().collect::<Vec<_>>())
            .expect("row");
        assert_eq!(hasher.finish().expect("hash"), whole);
        assert_ne!(film_hash(&plan, 0).expect("hash"), whole);
    }
}
