//! How the light of a film is spread over its samples: a histogram by brightness
//! that finds fireflies, rare samples that carry much of the picture.

use super::{FilmError, fixed};
use serde::{Deserialize, Serialize};

/// Bins of a [`Brightness`]: two for each power of two from 1 to 3 x 2^50, what
/// R + G + B of one sample can reach in fixed point.
pub const BRIGHTNESS_BINS: usize = 104;

/// Samples of about one brightness.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct BrightnessBin {
    /// How many.
    pub samples: u64,
    /// Sum of their R + G + B, fixed point 2^-24.
    pub light: u128,
}

/// Histogram of samples over R + G + B in fixed point. Counts and sums are
/// integers, so histograms add in any order, like the film; the sum over all bins
/// is that of the film's radiance. It is not part of the film hash.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Brightness {
    /// [`BRIGHTNESS_BINS`] bins, rising; none where nothing is known, in films of
    /// before there were any.
    pub bins: Vec<BrightnessBin>,
}

/// Exponent and first digit of 1.0.
const ONE_DIGITS: usize = (1.0_f64.to_bits() >> 51) as usize;

/// The bin of a sample whose R + G + B is `light`: exponent and first digit after
/// the point of the number as a double, which is exact below 2^53. The lowest digit
/// is set, which saves asking for zero: 0 shares the bin of 1, 2 that of 3.
#[inline]
#[must_use]
pub fn brightness_bin(light: i64) -> usize {
    ((((light | 1) as f64).to_bits() >> 51) as usize).wrapping_sub(ONE_DIGITS)
}

/// The smallest `light` of a bin; 0 of the first.
fn bin_start(bin: usize) -> u128 {
    match bin {
        0 => 0,
        1..=3 => 2,
        _ => {
            let octave = 1u128 << (bin / 2);
            octave + if bin % 2 == 1 { octave / 2 } else { 0 }
        }
    }
}

/// A histogram that is being recorded: [`brightness_bin`] without what one run can
/// spare, since every sample of the renderer comes here.
#[derive(Clone, Debug)]
pub struct BrightnessTally {
    samples: [u64; TALLY_BINS],
    light: [u128; TALLY_BINS],
}

/// A power of two above [`BRIGHTNESS_BINS`]: exponents and first digits modulo this
/// are still different, and need no bound to be checked.
const TALLY_BINS: usize = 128;

impl Default for BrightnessTally {
    fn default() -> Self {
        Self {
            samples: [0; TALLY_BINS],
            light: [0; TALLY_BINS],
        }
    }
}

impl BrightnessTally {
    /// Add one sample of R + G + B = `light`, at most 3 x 2^50 and not negative.
    #[inline]
    pub fn record(&mut self, light: i64) {
        let digits = ((light | 1) as f64).to_bits() >> 51;
        let bin = digits as usize % TALLY_BINS;
        self.samples[bin] += 1;
        self.light[bin] += light as u128;
    }

    /// The histogram.
    #[must_use]
    pub fn finish(&self) -> Brightness {
        let mut brightness = Brightness::zero();
        for (index, bin) in brightness.bins.iter_mut().enumerate() {
            let from = (index + ONE_DIGITS) % TALLY_BINS;
            bin.samples = self.samples[from];
            bin.light = self.light[from];
        }
        brightness
    }
}

impl Brightness {
    /// Every bin empty.
    #[must_use]
    pub fn zero() -> Self {
        Self {
            bins: vec![BrightnessBin::default(); BRIGHTNESS_BINS],
        }
    }

    /// Add one sample of R + G + B = `light`.
    #[inline]
    pub fn record(&mut self, light: i64) {
        if let Some(bin) = self.bins.get_mut(brightness_bin(light)) {
            bin.samples += 1;
            bin.light += light as u128;
        }
    }

    /// Add the samples of `other`.
    pub fn add(&mut self, other: &Self) {
        if self.bins.len() < other.bins.len() {
            self.bins.resize(other.bins.len(), BrightnessBin::default());
        }
        for (bin, more) in self.bins.iter_mut().zip(&other.bins) {
            bin.samples = bin.samples.saturating_add(more.samples);
            bin.light = bin.light.saturating_add(more.light);
        }
    }

    /// Samples of all bins.
    #[must_use]
    pub fn samples(&self) -> u64 {
        let add = |sum: u64, bin: &BrightnessBin| sum.saturating_add(bin.samples);
        self.bins.iter().fold(0, add)
    }

    /// R + G + B of all samples, fixed point.
    #[must_use]
    pub fn light(&self) -> u128 {
        let add = |sum: u128, bin: &BrightnessBin| sum.saturating_add(bin.light);
        self.bins.iter().fold(0, add)
    }

    /// The share of all light, 0 to 1, that the brightest `share` of the samples
    /// carries, at least one of them; `None` without samples or light. Of a bin
    /// that is brightest only in part the mean is taken, so that the answer errs by
    /// less than a factor of 1.5, to the low side.
    #[must_use]
    pub fn share_of_brightest(&self, share: f64) -> Option<f64> {
        let (samples, light) = (self.samples(), self.light());
        if samples == 0 || light == 0 {
            return None;
        }
        let mut left = (samples as f64 * share).max(1.0);
        let mut brightest = 0.0;
        for bin in self.bins.iter().rev().filter(|bin| bin.samples > 0) {
            let taken = left.min(bin.samples as f64);
            brightest += bin.light as f64 * (taken / bin.samples as f64);
            left -= taken;
            if left <= 0.0 {
                break;
            }
        }
        Some((brightest / light as f64).min(1.0))
    }

    /// Whether this is the histogram of `samples` samples whose R + G + B is
    /// `light` in all.
    pub(super) fn check(&self, samples: u64, light: u128) -> Result<(), FilmError> {
        if self.bins.len() != BRIGHTNESS_BINS {
            return Err(FilmError::Shape("brightness has another number of bins"));
        }
        for (index, bin) in self.bins.iter().enumerate() {
            let reach = |start: u128| u128::from(bin.samples).saturating_mul(start);
            let most = (bin_start(index + 1) - 1).min(3 * fixed::FIXED_SAMPLE_MAX as u128);
            if bin.light < reach(bin_start(index)) || bin.light > reach(most) {
                return Err(FilmError::Shape(
                    "a bin of brightness holds light that its samples cannot have",
                ));
            }
        }
        if self.samples() != samples || self.light() != light {
            return Err(FilmError::Shape(
                "brightness holds other samples or other light than the sums",
            ));
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_value_is_in_the_bin_that_holds_it() {
        let most = 3 * fixed::FIXED_SAMPLE_MAX;
        let mut values: Vec<i64> = (0..5000).collect();
        for digit in 1..52 {
            let power = 1i64 << digit;
            let half = power + power / 2;
            values.extend([power - 1, power, power + 1, half - 1, half, half + 1]);
        }
        values.push(most);
        for value in values.into_iter().filter(|&value| value <= most) {
            let bin = brightness_bin(value);
            assert!(bin < BRIGHTNESS_BINS, "{value}");
            let held = bin_start(bin)..bin_start(bin + 1);
            assert!(held.contains(&(value as u128)), "{value} {bin} {held:?}");
        }
    }

    #[test]
    fn the_brightest_are_found() {
        let mut even = Brightness::zero();
        (0..100_000).for_each(|_| even.record(1000));
        assert_eq!(even.share_of_brightest(1e-4), Some(1e-4));
        let mut firefly = even.clone();
        firefly.record(100_000_000);
        let share = firefly.share_of_brightest(1e-4).expect("light");
        assert!((share - 0.5).abs() < 1e-3, "{share}");
        assert_eq!(Brightness::default().share_of_brightest(1e-4), None);
        assert_eq!(Brightness::zero().share_of_brightest(1e-4), None);
        // One sample of few.
        let mut few = Brightness::zero();
        [1 << 20, 3 << 20].into_iter().for_each(|v| few.record(v));
        assert_eq!(few.share_of_brightest(1e-4), Some(0.75));
    }

    #[test]
    fn any_order_gives_one_histogram_and_an_old_one_adds_nothing() {
        let (mut left, mut right) = (Brightness::zero(), Brightness::zero());
        (0..1000).for_each(|v| left.record(v * v * v));
        (0..777).for_each(|v| right.record(v * 5));
        let mut one = left.clone();
        one.add(&right);
        one.add(&Brightness::default());
        let mut other = Brightness::default();
        other.add(&right);
        other.add(&left);
        assert_eq!(one, other);
        assert_eq!(one.check(1777, one.light()), Ok(()));
    }

    #[test]
    fn a_tally_is_the_histogram() {
        let (mut tally, mut whole) = (BrightnessTally::default(), Brightness::zero());
        let most = 3 * fixed::FIXED_SAMPLE_MAX;
        for light in (0..9999).chain((0..52).flat_map(|d| [1 << d, (3 << d) / 2, most >> d])) {
            let light = light.min(most);
            tally.record(light);
            whole.record(light);
        }
        assert_eq!(tally.finish(), whole);
        // More than 64 bits of light.
        (0..10_000).for_each(|_| tally.record(most));
        assert!(tally.finish().light() > u128::from(u64::MAX));
    }

    #[test]
    fn impossible_histograms_are_refused() {
        let mut good = Brightness::zero();
        for light in [0, 1, 2, 3, 1 << 30, 3 << 50] {
            good.record(light);
        }
        let light = good.light();
        assert_eq!(good.check(6, light), Ok(()));
        assert!(good.check(5, light).is_err());
        assert!(good.check(6, light + 1).is_err());
        let mut moved = good.clone();
        moved.bins[60].light += 1;
        moved.bins[61] = moved.bins[60];
        moved.bins[60] = BrightnessBin::default();
        assert!(moved.check(6, moved.light()).is_err());
        let mut huge = good.clone();
        huge.bins[103].light *= 2;
        assert!(huge.check(6, huge.light()).is_err());
        good.bins.pop();
        assert!(good.check(6, light).is_err());
    }
}
