//! The picture of a frame, finished or not.

use super::error::FoldError;
use super::tile;
use crate::app::App;
use crate::develop::Picture;
use crate::store::{FrameTile, JobRow};
use shearwater_shared::film::TileFilm;
use shearwater_shared::plan::TileRect;

/// Which planes a picture gets; each costs memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Planes {
    /// Beauty and sample count.
    Beauty,
    /// Variance, albedo, normal and depth too.
    All,
}

/// Put the picture of a frame together from what is stored at this moment, one
/// tile in memory at a time. Pixels without samples are black.
pub(crate) async fn picture(
    app: &App,
    job: &JobRow,
    frame: u32,
    planes: Planes,
) -> Result<Picture, FoldError> {
    let plan = job.plan();
    let mut picture = blank(plan.width(), plan.height(), planes);
    for tile in 0..plan.tiles() {
        let at = FrameTile {
            job: job.id,
            frame,
            tile,
        };
        let Some((film, _)) = tile::read(app, &plan, &at).await? else {
            break;
        };
        let Some(rect) = plan.tile_rect(tile) else {
            break;
        };
        if film.samples_per_half == 0 {
            continue;
        }
        picture = app
            .compute(move || {
                paint(&mut picture, &film, &rect);
                picture
            })
            .await?;
    }
    Ok(picture)
}

fn blank(width: u32, height: u32, planes: Planes) -> Picture {
    let pixels = width as usize * height as usize;
    let colour = || (planes == Planes::All).then(|| vec![[0.0; 3]; pixels]);
    Picture {
        width,
        height,
        beauty: vec![[0.0; 3]; pixels],
        variance: colour(),
        albedo: colour(),
        normal: colour(),
        depth: (planes == Planes::All).then(|| vec![f32::INFINITY; pixels]),
        sample_count: vec![0; pixels],
    }
}

/// Write the means of a tile into the picture.
fn paint(picture: &mut Picture, film: &TileFilm, rect: &TileRect) {
    let (stride, columns) = (picture.width as usize, rect.width as usize);
    let samples = u32::try_from(2 * film.samples_per_half).unwrap_or(u32::MAX);
    for from in 0..film.pixels() {
        let (x, y) = (from % columns, from / columns);
        let to = (rect.y0 as usize + y) * stride + rect.x0 as usize + x;
        picture.beauty[to] = film.mean(from).map(|v| v as f32);
        picture.sample_count[to] = samples;
        if let Some(variance) = &mut picture.variance {
            let (a, b) = (film.half_mean(0, from), film.half_mean(1, from));
            variance[to] = [0, 1, 2].map(|c| ((a[c] - b[c]) * (a[c] - b[c]) * 0.25) as f32);
        }
        if picture.depth.is_some() {
            paint_features(picture, &film.feature_mean(from), to);
        }
    }
}

fn paint_features(picture: &mut Picture, mean: &[f64; 8], to: usize) {
    let [red, green, blue, nx, ny, nz, depth_sum, hits] = *mean;
    if let Some(albedo) = &mut picture.albedo {
        albedo[to] = [red, green, blue].map(|v| v as f32);
    }
    if let Some(normal) = &mut picture.normal {
        normal[to] = [nx, ny, nz].map(|v| v as f32);
    }
    if let Some(depth) = &mut picture.depth
        && hits > 0.0
    {
        // Samples that left the scene add no distance: average the hits only.
        depth[to] = (depth_sum / hits) as f32;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use shearwater_shared::film::{FEATURE_CHANNELS, TileSums};

    const ONE: i64 = 1 << 24;

    #[test]
    fn means_variance_and_features_land_on_their_pixel() {
        let rect = TileRect {
            x0: 2,
            y0: 1,
            width: 2,
            height: 2,
        };
        let mut sums = TileSums::zero(4, &(0..2));
        sums.radiance[0][3 * 3] = 6 * ONE; // half A, last pixel, red: mean 3
        sums.radiance[1][3 * 3] = 2 * ONE; // half B: mean 1
        let last = FEATURE_CHANNELS * 3;
        sums.features[last] = 2 * ONE; // albedo red over 4 samples
        sums.features[last + 6] = 30 * ONE; // distances of
        sums.features[last + 7] = 3 * ONE; // three hits
        let mut film = TileFilm::zero(4);
        film.add(&sums).expect("fits");
        let mut picture = blank(5, 4, Planes::All);
        paint(&mut picture, &film, &rect);
        let at = 2 * 5 + 3;
        assert_eq!(picture.beauty[at], [2.0, 0.0, 0.0]);
        assert_eq!(picture.sample_count[at], 4);
        assert_eq!(picture.sample_count[0], 0);
        assert_eq!(picture.variance.expect("plane")[at], [1.0, 0.0, 0.0]);
        assert_eq!(picture.albedo.expect("plane")[at], [0.5, 0.0, 0.0]);
        let depth = picture.depth.expect("plane");
        assert_eq!(depth[at], 10.0);
        assert_eq!(depth[at - 1], f32::INFINITY);
    }
}
