//! Walker's alias table: a discrete distribution sampled in constant time.

/// A discrete distribution over `0..len`.
#[derive(Clone, Debug)]
pub struct AliasTable {
    // Probability of staying in the drawn slot, and where to go otherwise.
    slots: Vec<(f32, u32)>,
}

impl AliasTable {
    /// The distribution proportional to `weights`; `None` when they are empty, or
    /// none is positive. Negative and non-finite weights count as 0. Built in f64
    /// in a fixed order (Vose 1991).
    #[must_use]
    pub fn new(weights: &[f32]) -> Option<Self> {
        let clean = |w: f32| {
            if w.is_finite() && w > 0.0 {
                f64::from(w)
            } else {
                0.0
            }
        };
        let sum: f64 = weights.iter().map(|&w| clean(w)).sum();
        if sum <= 0.0 || !sum.is_finite() || u32::try_from(weights.len()).is_err() {
            return None;
        }
        let scale = weights.len() as f64 / sum;
        let mut share: Vec<f64> = weights.iter().map(|&w| clean(w) * scale).collect();
        let (mut small, mut large): (Vec<u32>, Vec<u32>) =
            (0..weights.len() as u32).partition(|&i| share[i as usize] < 1.0);
        let mut slots = vec![(1.0f32, 0u32); weights.len()];
        while let (Some(&low), Some(&high)) = (small.last(), large.last()) {
            small.pop();
            slots[low as usize] = (share[low as usize] as f32, high);
            share[high as usize] -= 1.0 - share[low as usize];
            if share[high as usize] < 1.0 {
                large.pop();
                small.push(high);
            }
        }
        // What is left differs from 1 by rounding only, except slots of weight 0,
        // which must never be drawn.
        let heaviest = (0..weights.len() as u32)
            .max_by(|&a, &b| clean(weights[a as usize]).total_cmp(&clean(weights[b as usize])));
        for i in small.into_iter().chain(large) {
            slots[i as usize] = (
                if clean(weights[i as usize]) > 0.0 {
                    1.0
                } else {
                    0.0
                },
                heaviest.unwrap_or(0),
            );
        }
        Some(Self { slots })
    }

    /// Draw an index with `u` in [0, 1); also what is left of `u`, again
    /// uniform in [0, 1).
    #[inline]
    #[must_use]
    pub fn sample(&self, u: f32) -> (u32, f32) {
        let n = self.slots.len();
        // The middle of the 2^-24 wide step that `u` stands for: choices are then
        // rounded, not cut. f64, since f32 has no bits left below the slot.
        let scaled = (f64::from(u) + 0.5 / 16_777_216.0) * n as f64;
        let slot = (scaled as usize).min(n - 1);
        let rest = ((scaled - slot as f64) as f32).min(1.0 - f32::EPSILON / 2.0);
        let (stay, other) = self.slots[slot];
        if rest < stay {
            (slot as u32, (rest / stay).min(1.0 - f32::EPSILON / 2.0))
        } else {
            (
                other,
                ((rest - stay) / (1.0 - stay)).clamp(0.0, 1.0 - f32::EPSILON / 2.0),
            )
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frequencies_follow_weights() {
        let weights = [0.0, 1.0, 3.0, 0.5, 0.0, 10.0, f32::NAN, -4.0];
        let table = AliasTable::new(&weights).expect("positive weights");
        let mut counts = [0u32; 8];
        let n = 1 << 20;
        for i in 0..n {
            let (index, rest) = table.sample((i as f32 + 0.5) / n as f32);
            assert!((0.0..1.0).contains(&rest));
            counts[index as usize] += 1;
        }
        for (count, weight) in counts.iter().zip([0.0, 1.0, 3.0, 0.5, 0.0, 10.0, 0.0, 0.0]) {
            let expected = weight / 14.5 * f64::from(n);
            assert!((f64::from(*count) - expected).abs() <= 8.0, "{counts:?}");
            assert_eq!(*count == 0, weight == 0.0);
        }
    }

    #[test]
    fn nothing_to_draw_is_none() {
        assert!(AliasTable::new(&[]).is_none());
        assert!(AliasTable::new(&[0.0, 0.0]).is_none());
        assert!(AliasTable::new(&[f32::NAN]).is_none());
    }

    // A flat f32 CDF of as many bins would lose the light ones.
    #[test]
    fn uneven_weights_keep_their_share() {
        let weights: Vec<f32> = (0..4096u32)
            .map(|i| if i % 64 == 0 { 1.0 } else { 1e-3 })
            .collect();
        let table = AliasTable::new(&weights).expect("positive");
        let n = 1u32 << 22;
        let light = (0..n)
            .filter(|&i| !table.sample(i as f32 / n as f32).0.is_multiple_of(64))
            .count() as f64;
        let expected = 4032.0 * 1e-3 / (64.0 + 4032.0 * 1e-3) * f64::from(n);
        assert!(
            (light / expected - 1.0).abs() < 0.01,
            "{light} against {expected}"
        );
    }
}
