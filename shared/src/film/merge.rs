//! The merged film of a tile, and the hash of a whole film.

use super::{BadSamples, Brightness, FEATURE_CHANNELS, FIXED_ONE, TileSums, fixed};
use crate::hash::ContentHash;
use crate::limits::{FEATURE_SAMPLES, SAMPLES_MAX};
use crate::plan::Plan;
use serde::{Deserialize, Serialize};

/// Sums that do not fit together.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum FilmError {
    /// A part has another shape than its run.
    #[error("the part does not fit its run: {0}")]
    Shape(&'static str),
    /// Two tiles differ in pixels.
    #[error("a part of {part} pixels cannot be added to a tile of {tile}")]
    Pixels {
        /// Pixels of the tile.
        tile: usize,
        /// Pixels of the part.
        part: usize,
    },
}

/// Sums of any set of runs of one tile. Adding is exact, so the order, the cut
/// and the number of parts leave no trace in it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct TileFilm {
    /// Samples summed per pixel in each half.
    pub samples_per_half: u64,
    /// RGB sums of half A then half B, as in [`TileSums::radiance`].
    pub radiance: [Vec<i128>; 2],
    /// Feature samples summed per pixel, both halves.
    pub feature_samples: u64,
    /// Feature sums, as in [`TileSums::features`].
    pub features: Vec<i128>,
    /// Bad samples of all parts.
    pub bad: BadSamples,
    /// Paths that ended at the safety cap.
    pub depth_cap_hits: u64,
    /// How the light is spread over the samples; of those that were summed before
    /// this was recorded nothing is in it.
    pub brightness: Brightness,
}

impl TileFilm {
    /// A tile of `pixels` pixels without samples.
    #[must_use]
    pub fn zero(pixels: usize) -> Self {
        Self {
            samples_per_half: 0,
            radiance: [vec![0; 3 * pixels], vec![0; 3 * pixels]],
            feature_samples: 0,
            features: vec![0; FEATURE_CHANNELS * pixels],
            bad: BadSamples::default(),
            depth_cap_hits: 0,
            brightness: Brightness::default(),
        }
    }

    /// Pixels of the tile.
    #[must_use]
    pub fn pixels(&self) -> usize {
        self.radiance[0].len() / 3
    }

    /// Whether this can be a film of a tile of `pixels` pixels: its shape, and sums
    /// that its samples can reach. For what comes out of a store.
    ///
    /// # Errors
    /// Says which part does not fit.
    pub fn check(&self, pixels: usize) -> Result<(), FilmError> {
        if self.radiance.iter().any(|half| half.len() != 3 * pixels)
            || self.features.len() != FEATURE_CHANNELS * pixels
        {
            return Err(FilmError::Pixels {
                tile: pixels,
                part: self.pixels(),
            });
        }
        if self.samples_per_half > u64::from(SAMPLES_MAX / 2)
            || self.feature_samples > u64::from(2 * FEATURE_SAMPLES)
        {
            return Err(FilmError::Shape("more samples than a job can have"));
        }
        let reach = |samples: u64| i128::from(samples) * i128::from(fixed::FIXED_SAMPLE_MAX);
        let most = reach(self.samples_per_half);
        let mut sums = self.radiance.iter().flatten();
        if sums.any(|&sum| sum < 0 || sum > most) {
            return Err(FilmError::Shape(
                "a radiance sum is negative or larger than its samples can reach",
            ));
        }
        let most = reach(self.feature_samples);
        if self.features.iter().any(|&sum| sum < -most || sum > most) {
            return Err(FilmError::Shape(
                "a feature sum is larger than its samples can reach",
            ));
        }
        Ok(())
    }

    /// Add one part.
    ///
    /// # Errors
    /// The part has another number of pixels.
    pub fn add(&mut self, part: &TileSums) -> Result<(), FilmError> {
        let (tile, pixels) = (self.pixels(), part.radiance[0].len() / 3);
        let fits = part.radiance.iter().all(|half| half.len() == 3 * tile)
            && (part.features.is_empty() || part.features.len() == FEATURE_CHANNELS * tile);
        if !fits {
            return Err(FilmError::Pixels { tile, part: pixels });
        }
        for (sums, add) in self.radiance.iter_mut().zip(&part.radiance) {
            add_into(sums, add);
        }
        add_into(&mut self.features, &part.features);
        self.samples_per_half += u64::from(part.samples_per_half);
        self.feature_samples += u64::from(part.feature_samples);
        self.depth_cap_hits = self.depth_cap_hits.saturating_add(part.depth_cap_hits);
        self.bad.merge(&part.bad);
        self.brightness.add(&part.brightness);
        Ok(())
    }

    /// Add another film of the same tile, made of other runs.
    ///
    /// # Errors
    /// The film has another number of pixels.
    pub fn add_film(&mut self, other: &Self) -> Result<(), FilmError> {
        let (tile, part) = (self.pixels(), other.pixels());
        let halves = self.radiance.iter().zip(&other.radiance);
        let fits = halves.into_iter().all(|(a, b)| a.len() == b.len());
        if !fits || other.features.len() != self.features.len() {
            return Err(FilmError::Pixels { tile, part });
        }
        for (sums, add) in self.radiance.iter_mut().zip(&other.radiance) {
            add_into(sums, add);
        }
        add_into(&mut self.features, &other.features);
        self.samples_per_half += other.samples_per_half;
        self.feature_samples += other.feature_samples;
        self.depth_cap_hits = self.depth_cap_hits.saturating_add(other.depth_cap_hits);
        self.bad.merge(&other.bad);
        self.brightness.add(&other.brightness);
        Ok(())
    }

    /// Mean radiance of one half at `pixel`; zero without samples.
    #[must_use]
    pub fn half_mean(&self, half: usize, pixel: usize) -> [f64; 3] {
        let scale = mean_scale(self.samples_per_half);
        [0, 1, 2].map(|c| self.radiance[half][3 * pixel + c] as f64 * scale)
    }

    /// Mean radiance over both halves at `pixel`; zero without samples. The sum
    /// is exact; one division rounds.
    #[must_use]
    pub fn mean(&self, pixel: usize) -> [f64; 3] {
        let scale = mean_scale(2 * self.samples_per_half);
        [0, 1, 2].map(|c| {
            (self.radiance[0][3 * pixel + c] + self.radiance[1][3 * pixel + c]) as f64 * scale
        })
    }

    /// Mean features at `pixel`; zero without feature samples.
    #[must_use]
    pub fn feature_mean(&self, pixel: usize) -> [f64; FEATURE_CHANNELS] {
        let scale = mean_scale(self.feature_samples);
        std::array::from_fn(|c| self.features[FEATURE_CHANNELS * pixel + c] as f64 * scale)
    }
}

fn add_into<T: Copy + Into<i128>>(sums: &mut [i128], add: &[T]) {
    for (sum, &value) in sums.iter_mut().zip(add) {
        *sum = sum.saturating_add(value.into());
    }
}

fn mean_scale(samples: u64) -> f64 {
    if samples == 0 {
        0.0
    } else {
        1.0 / (samples as f64 * FIXED_ONE)
    }
}

/// The hash of a frame's film: blake3 over width, height and then, row by row,
/// each pixel's sample count per half (u64) and its six sums (i128), all little
/// endian. Independent of tiles and blocks: equal films have equal hashes
/// however they were cut. Features are left out: they are not the picture.
///
/// `tile` gives the film of each tile of `plan` in turn.
///
/// # Errors
/// A tile has another number of pixels than its plan says.
pub fn film_hash<'a>(
    plan: &Plan,
    tile: impl Fn(u32) -> &'a TileFilm,
) -> Result<ContentHash, FilmError> {
    let mut hasher = FilmHasher::new(*plan);
    for first in (0..plan.tiles()).step_by(plan.tiles_x().max(1) as usize) {
        let band: Vec<&TileFilm> = (first..first + plan.tiles_x()).map(&tile).collect();
        hasher.add_band(&band)?;
    }
    hasher.finish()
}

/// [`film_hash`] of films that come one row of tiles after the other, so that
/// only one row need be in memory.
#[derive(Debug)]
pub struct FilmHasher {
    plan: Plan,
    next_tile: u32,
    hasher: blake3::Hasher,
}

impl FilmHasher {
    /// Begin a frame of `plan`.
    #[must_use]
    pub fn new(plan: Plan) -> Self {
        let mut hasher = blake3::Hasher::new();
        hasher.update(b"shearwater film 1");
        hasher.update(&plan.width().to_le_bytes());
        hasher.update(&plan.height().to_le_bytes());
        Self {
            plan,
            next_tile: 0,
            hasher,
        }
    }

    /// Add the next row of tiles, left to right: [`Plan::tiles_x`] films.
    ///
    /// # Errors
    /// A row of another length, one row too many, or a tile that has another
    /// number of pixels than its plan says.
    pub fn add_band(&mut self, band: &[&TileFilm]) -> Result<(), FilmError> {
        if band.len() != self.plan.tiles_x() as usize || self.next_tile >= self.plan.tiles() {
            return Err(FilmError::Shape("a row of tiles is not that of the plan"));
        }
        let mut rects = Vec::with_capacity(band.len());
        for (film, tile) in band.iter().zip(self.next_tile..) {
            let rect = self.plan.tile_rect(tile);
            let pixels = rect.map_or(0, |rect| rect.pixels());
            if film.pixels() != pixels {
                return Err(FilmError::Pixels {
                    tile: pixels,
                    part: film.pixels(),
                });
            }
            rects.extend(rect);
        }
        let mut row = Vec::new();
        for y in 0..rects.first().map_or(0, |r| r.height) as usize {
            row.clear();
            for (film, rect) in band.iter().zip(&rects) {
                push_row(&mut row, film, y, rect.width as usize);
            }
            self.hasher.update(&row);
        }
        self.next_tile += self.plan.tiles_x();
        Ok(())
    }

    /// The hash of the frame.
    ///
    /// # Errors
    /// Rows of tiles are missing.
    pub fn finish(&self) -> Result<ContentHash, FilmError> {
        if self.next_tile < self.plan.tiles() {
            return Err(FilmError::Shape("rows of tiles are missing"));
        }
        Ok(ContentHash::from_bytes(*self.hasher.finalize().as_bytes()))
    }
}

fn push_row(bytes: &mut Vec<u8>, film: &TileFilm, y: usize, width: usize) {
    for pixel in y * width..(y + 1) * width {
        for half in &film.radiance {
            bytes.extend_from_slice(&film.samples_per_half.to_le_bytes());
            for sum in &half[3 * pixel..3 * pixel + 3] {
                bytes.extend_from_slice(&sum.to_le_bytes());
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::job::RenderSettings;

    fn part(pixels: usize, seed: i64, samples: std::ops::Range<u32>) -> TileSums {
        let mut sums = TileSums::zero(pixels, &samples);
        for (half, values) in sums.radiance.iter_mut().enumerate() {
            for (i, v) in values.iter_mut().enumerate() {
                *v = (seed * 7919 + half as i64 * 31 + i as i64) % 1_000_003;
            }
        }
        sums
    }

    #[test]
    fn any_order_and_cut_gives_one_film() {
        let parts: Vec<_> = (0..9)
            .map(|i| part(12, i, i as u32 * 4..i as u32 * 4 + 4))
            .collect();
        let mut forward = TileFilm::zero(12);
        parts.iter().for_each(|p| forward.add(p).expect("fits"));
        let mut backward = TileFilm::zero(12);
        parts
            .iter()
            .rev()
            .for_each(|p| backward.add(p).expect("fits"));
        assert_eq!(forward, backward);
        let (mut left, mut right) = (TileFilm::zero(12), TileFilm::zero(12));
        parts[..4].iter().for_each(|p| left.add(p).expect("fits"));
        parts[4..].iter().for_each(|p| right.add(p).expect("fits"));
        right.add_film(&left).expect("fits");
        assert_eq!(forward, right);
    }

    #[test]
    fn parts_of_another_size_are_refused() {
        assert!(TileFilm::zero(12).add(&part(11, 0, 0..4)).is_err());
        let mut broken = part(12, 0, 0..4);
        broken.radiance[1].pop();
        assert!(TileFilm::zero(12).add(&broken).is_err());
    }

    #[test]
    fn hash_sees_every_value_and_only_the_picture() {
        let plan = Plan::new(&RenderSettings {
            width: 100,
            height: 70,
            samples: 8,
            seed: 0,
            frames: 1,
            first_frame: 0,
            stop: crate::stop::Stop::NONE,
        });
        let tiles: Vec<TileFilm> = (0..plan.tiles())
            .map(|t| {
                let pixels = plan.tile_rect(t).expect("tile").pixels();
                let mut film = TileFilm::zero(pixels);
                film.add(&part(pixels, t.into(), 0..4)).expect("fits");
                film
            })
            .collect();
        let hash = |tiles: &[TileFilm]| film_hash(&plan, |t| &tiles[t as usize]).expect("hash");
        let reference = hash(&tiles);
        let mut feature = tiles.clone();
        feature[0].features[3] += 1;
        assert_eq!(hash(&feature), reference);
        let mut one_unit = tiles.clone();
        one_unit[3].radiance[1][5] += 1;
        assert_ne!(hash(&one_unit), reference);
        let mut swapped = tiles;
        swapped[0].radiance.swap(0, 1);
        assert_ne!(hash(&swapped), reference);
    }

    #[test]
    fn checks_shape_and_reach() {
        let rect = crate::plan::TileRect {
            x0: 0,
            y0: 0,
            width: 4,
            height: 3,
        };
        let mut good = part(12, 1, 0..4);
        // Each sum as four samples as even as may be.
        for sum in good.radiance.iter().flat_map(|half| half.chunks_exact(3)) {
            let light: i64 = sum.iter().sum();
            (0..4).for_each(|i| good.brightness.record((light + i) / 4));
        }
        assert_eq!(good.check(&rect, &(0..4)), Ok(()));
        assert!(good.check(&rect, &(0..5)).is_err());
        assert!(
            good.check(&rect, &(20..24)).is_err(),
            "features beyond the feature samples"
        );
        let mut lost = good.clone();
        lost.radiance[1][7] += 1;
        assert!(lost.check(&rect, &(0..4)).is_err(), "light from nowhere");
        let mut negative = good.clone();
        negative.radiance[0][0] = -1;
        assert!(negative.check(&rect, &(0..4)).is_err());
        let mut huge = good;
        huge.radiance[0][0] = i64::MAX;
        assert!(huge.check(&rect, &(0..4)).is_err());
    }
}
