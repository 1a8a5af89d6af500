//! Colours and brushes: coverage from signed distances, in metres.

/// A colour in sRGB, 0 to 255.
pub(super) type Colour = [f64; 3];

/// Warm cream of the upper skin.
pub(super) const CREAM: Colour = [236.0, 226.0, 205.0];
/// Bare, waxed aluminium.
pub(super) const ALUMINIUM: Colour = [196.0, 197.0, 199.0];
/// Deep sea blue of the cheat line.
pub(super) const NAVY: Colour = [22.0, 52.0, 92.0];
/// Orange of the pinstripe and the tips.
pub(super) const ORANGE: Colour = [226.0, 98.0, 28.0];
/// Rubber of the de-icing boots.
pub(super) const RUBBER: Colour = [38.0, 38.0, 40.0];
/// Shadow of seams.
pub(super) const SEAM: Colour = [70.0, 70.0, 72.0];

/// Lays `over` on `under` with an opacity in [0, 1].
#[must_use]
pub(super) fn over(under: Colour, over: Colour, opacity: f64) -> Colour {
    std::array::from_fn(|i| under[i] + (over[i] - under[i]) * opacity)
}

/// Coverage of a shape from its signed distance (negative inside), softened
/// over one texel of `texel_m` metres.
#[must_use]
pub(super) fn cover(distance_m: f64, texel_m: f64) -> f64 {
    (0.5 - distance_m / texel_m).clamp(0.0, 1.0)
}

/// Coverage of a band between two values.
#[must_use]
pub(super) fn band(value: f64, from: f64, to: f64, texel_m: f64) -> f64 {
    cover((from - value).max(value - to), texel_m)
}

/// Coverage of a seam of `width_m` at `place`.
#[must_use]
pub(super) fn seam(value: f64, place: f64, width_m: f64, texel_m: f64) -> f64 {
    // A seam narrower than a texel keeps its weight, not its darkness.
    let wide = width_m.max(texel_m);
    band(value, place - 0.5 * wide, place + 0.5 * wide, texel_m) * (width_m / wide)
}

/// Signed distance of a point to a rectangle with round corners.
#[must_use]
pub(super) fn round_rect(p: (f64, f64), middle: (f64, f64), half: (f64, f64), radius: f64) -> f64 {
    let dx = (p.0 - middle.0).abs() - half.0 + radius;
    let dy = (p.1 - middle.1).abs() - half.1 + radius;
    let outside = (dx.max(0.0) * dx.max(0.0) + dy.max(0.0) * dy.max(0.0)).sqrt();
    outside + dx.max(dy).min(0.0) - radius
}
