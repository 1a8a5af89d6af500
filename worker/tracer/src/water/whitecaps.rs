//! Foam where choppy waves fold.

use shearwater_shared::scene::Whitecaps;

/// Share of each point that is under foam, 0 to 1, from the derivatives of the
/// displacement towards the crests.
///
/// Choppy waves move the water at x to x + D, D = sum i c k/|k| h e^{ikx}, which is
/// Tessendorf's displacement (2001, equation 44) with the sign that sharpens crests.
/// Then dDx/dx = -c sum kx^2/|k| h e^{ikx}, and the area of a patch of water becomes J
/// times what it was (equation 46):
/// J = (1 + dDx/dx)(1 + dDz/dz) - (dDx/dz)^2.
pub(super) fn foam(
    caps: &Whitecaps,
    squeeze_x: &[f32],
    squeeze_z: &[f32],
    squeeze_xz: &[f32],
) -> Vec<f32> {
    let choppiness = caps.choppiness as f32;
    let threshold = caps.threshold as f32;
    let per_unit = (1.0 / caps.softness) as f32;
    let derivatives = squeeze_x.iter().zip(squeeze_z).zip(squeeze_xz);
    derivatives
        .map(|((&xx, &zz), &xz)| {
            let both = choppiness * xz;
            let area = (1.0 - choppiness * xx) * (1.0 - choppiness * zz) - both * both;
            ((threshold - area) * per_unit).clamp(0.0, 1.0)
        })
        .collect()
}
