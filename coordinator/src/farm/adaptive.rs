//! An error stop: which tiles of a frame go on after a pass.
//!
//! The error of the picture is the mean of its tiles' relative MSE e. With s = e n
//! for a tile of n samples, the fewest samples in all for a mean error E are spent
//! when n is proportional to sqrt(s) (Neyman 1934, on dividing a sample among
//! strata; by a Lagrange multiplier). Equal errors everywhere would need as many
//! samples as no choice at all. So each tile has a number of samples that it should
//! come to, and doubles until it is there.

use shearwater_shared::stop::ErrorTarget;

/// Of the largest spread around a tile, what the tile is taken to have at least: its
/// own estimate may have missed what its neighbours have seen.
const NEIGHBOUR_SHARE: f64 = 0.25;
/// A tile doubles when it should have this times its samples: half way to twice as
/// many, by ratio.
const DOUBLE_FROM: f64 = std::f64::consts::SQRT_2;
/// Halvings of the search for the common factor; a double has no more bits.
const HALVINGS: u32 = 64;

/// What is known of a tile when its frame stands between two passes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TileAtLevel {
    /// Samples per pixel that it has, more than 0.
    pub samples: u32,
    /// Whether it may have more.
    pub can_go_on: bool,
    /// Pixels.
    pub pixels: u32,
    /// Its relative mean squared error with its samples, not negative.
    pub relmse: f64,
}

/// What follows for a frame.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// The picture's error is at most the target.
    Reached,
    /// It is not, and the tiles that would need more samples have all they may have.
    Exhausted,
    /// These tiles, in order, double their samples.
    GoOn(Vec<u32>),
}

/// Decide about a frame: `tiles` are all of them, row by row, `tiles_x` in a row. A
/// function of its arguments alone.
#[must_use]
pub fn verdict(tiles: &[TileAtLevel], tiles_x: u32, target: ErrorTarget) -> Verdict {
    let pixels: f64 = tiles.iter().map(|tile| f64::from(tile.pixels)).sum();
    let allowed = target.get() * pixels;
    let error: f64 = tiles
        .iter()
        .map(|tile| f64::from(tile.pixels) * tile.relmse)
        .sum();
    if error <= allowed {
        return Verdict::Reached;
    }
    let spread = spread(tiles, tiles_x);
    let factor = common_factor(tiles, &spread, allowed);
    let wants = |from: f64| -> Vec<u32> {
        (0..)
            .zip(tiles.iter().zip(&spread))
            .filter(|(_, (tile, spread))| {
                tile.can_go_on && factor * **spread > from * f64::from(tile.samples)
            })
            .map(|(number, _)| number)
            .collect()
    };
    // Near the end nobody may be half way to the double and the sum still too large.
    [DOUBLE_FROM, 1.0]
        .into_iter()
        .map(wants)
        .find(|tiles| !tiles.is_empty())
        .map_or(Verdict::Exhausted, Verdict::GoOn)
}

/// sqrt(s) of each tile, or a share of the largest around it.
fn spread(tiles: &[TileAtLevel], tiles_x: u32) -> Vec<f64> {
    let own: Vec<f64> = tiles
        .iter()
        .map(|tile| (tile.relmse * f64::from(tile.samples)).sqrt())
        .collect();
    let columns = (tiles_x as usize).max(1);
    let rows = tiles.len().div_ceil(columns);
    let around = |at: usize| {
        let (x, y) = (at % columns, at / columns);
        let xs = x.saturating_sub(1)..(x + 2).min(columns);
        let ys = y.saturating_sub(1)..(y + 2).min(rows);
        ys.flat_map(move |y| xs.clone().map(move |x| y * columns + x))
    };
    (0..own.len())
        .map(|at| {
            let neighbours = around(at).filter_map(|near| own.get(near));
            let largest = neighbours.fold(0.0, |most: f64, &near| most.max(near));
            own.get(at)
                .copied()
                .unwrap_or(0.0)
                .max(NEIGHBOUR_SHARE * largest)
        })
        .collect()
}

/// The smallest factor f for which tiles of max(n, f sqrt(s)) samples have errors
/// that sum to at most `allowed`; samples that are rendered stay.
fn common_factor(tiles: &[TileAtLevel], spread: &[f64], allowed: f64) -> f64 {
    let error = |factor: f64| -> f64 {
        let of_tile = |(tile, spread): (&TileAtLevel, &f64)| {
            let samples = f64::from(tile.samples);
            let then = samples.max(factor * spread);
            f64::from(tile.pixels) * tile.relmse * samples / then
        };
        tiles.iter().zip(spread).map(of_tile).sum()
    };
    let (mut low, mut high) = (0.0, 1.0);
    while error(high) > allowed && high < 1e300 {
        high *= 2.0;
    }
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        if error(middle) > allowed {
            low = middle;
        } else {
            high = middle;
        }
    }
    high
}

#[cfg(test)]
mod tests {
    use super::*;

    fn target(error: f64) -> ErrorTarget {
        ErrorTarget::new(error).expect("target")
    }

    /// A tile of `samples` whose error falls as `s / samples`.
    fn tile(samples: u32, s: f64) -> TileAtLevel {
        TileAtLevel {
            samples,
            can_go_on: samples < 1 << 20,
            pixels: 4096,
            relmse: s / f64::from(samples),
        }
    }

    /// Double until the frame ends; the samples of each tile.
    fn run(s: &[f64], tiles_x: u32, error: f64) -> Vec<u32> {
        let mut samples = vec![64; s.len()];
        loop {
            let tiles: Vec<_> = samples.iter().zip(s).map(|(&n, &s)| tile(n, s)).collect();
            match verdict(&tiles, tiles_x, target(error)) {
                Verdict::GoOn(on) => on.iter().for_each(|&at| samples[at as usize] *= 2),
                Verdict::Reached => return samples,
                Verdict::Exhausted => panic!("nobody is at the end: {samples:?}"),
            }
        }
    }

    #[test]
    fn samples_follow_the_root_of_the_spread() {
        // Far from each other, so that no neighbour counts: every second is black.
        let s = [16.0, 0.0, 0.0, 256.0, 0.0, 0.0, 4096.0];
        let samples = run(&s, 7, 0.5);
        assert_eq!(samples[3], 4 * samples[0], "{samples:?}");
        assert_eq!(samples[6], 4 * samples[3], "{samples:?}");
        let error: f64 = s.iter().zip(&samples).map(|(s, &n)| s / f64::from(n)).sum();
        assert!((0.25..=0.5).contains(&(error / 7.0)), "{error}");
    }

    #[test]
    fn fewer_samples_than_everybody_the_same_for_one_error() {
        let s: Vec<f64> = (0..128u32)
            .map(|at| {
                if at % 16 < 6 {
                    1e-3
                } else {
                    let rough = f64::from(at % 7 + 1);
                    rough * rough * rough
                }
            })
            .collect();
        let samples = run(&s, 16, 0.05);
        let error: f64 = s
            .iter()
            .zip(&samples)
            .map(|(s, &n)| s / f64::from(n))
            .sum::<f64>()
            / 128.0;
        let mean: f64 = samples.iter().map(|&n| f64::from(n)).sum::<f64>() / 128.0;
        let uniform = s.iter().sum::<f64>() / 128.0 / error;
        assert!(
            error <= 0.05 && mean < 0.85 * uniform,
            "{mean} against {uniform}"
        );
    }

    #[test]
    fn what_is_reached_stays_and_neighbours_count() {
        assert_eq!(verdict(&[tile(64, 0.1)], 1, target(0.01)), Verdict::Reached);
        // The middle of 3 x 3 is bad: its neighbours go on before they show it.
        let mut s = [1e-9; 9];
        s[4] = 1e4;
        let tiles = s.map(|s| tile(64, s));
        let all = Verdict::GoOn((0..9).collect());
        assert_eq!(verdict(&tiles, 3, target(0.01)), all);
        // In a row of nine only two of them are near.
        let near = Verdict::GoOn(vec![3, 4, 5]);
        assert_eq!(verdict(&tiles, 9, target(0.01)), near);
    }

    #[test]
    fn who_has_all_samples_stops_and_the_others_do_not_pay_for_it() {
        let mut tiles = [tile(64, 1e3), tile(64, 0.0), tile(64, 0.0), tile(64, 1e-3)];
        tiles[0].can_go_on = false;
        assert_eq!(verdict(&tiles, 4, target(0.5)), Verdict::GoOn(vec![1]));
        tiles[1].can_go_on = false;
        assert_eq!(verdict(&tiles, 4, target(0.5)), Verdict::Exhausted);
    }

    #[test]
    fn black_and_strange_pictures_end() {
        assert_eq!(verdict(&[], 1, target(0.01)), Verdict::Reached);
        assert_eq!(
            verdict(&[tile(64, 0.0); 4], 2, target(0.01)),
            Verdict::Reached
        );
        let huge = [tile(64, 1e300), tile(64, 1.0)];
        assert_eq!(verdict(&huge, 1, target(1e-9)), Verdict::GoOn(vec![0, 1]));
    }
}
