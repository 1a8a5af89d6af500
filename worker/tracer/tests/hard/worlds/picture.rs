//! Pictures and how far apart they are.

use super::place;
use shearwater_shared::film::TileFilm;
use shearwater_shared::job::RenderSettings;
use shearwater_shared::plan::TileRect;
use shearwater_shared::scene::{SceneDescription, parse};
use shearwater_tracer::{BuildOptions, Scene, render_run};
use std::sync::atomic::AtomicBool;

const WIDTH: u32 = 40;
const HEIGHT: u32 = 20;

/// Both halves of a picture.
pub(crate) struct Picture {
    halves: [Vec<f64>; 2],
}

impl Picture {
    fn value(&self, i: usize) -> f64 {
        (self.halves[0][i] + self.halves[1][i]) / 2.0
    }

    pub(crate) fn mean(&self) -> f64 {
        let count = self.halves[0].len();
        (0..count).map(|i| self.value(i)).sum::<f64>() / count as f64
    }

    /// Estimated mean squared error.
    pub(crate) fn noise(&self) -> f64 {
        let [a, b] = &self.halves;
        let sum: f64 = a.iter().zip(b).map(|(a, b)| (a - b) * (a - b) / 4.0).sum();
        sum / a.len() as f64
    }
}

/// Mean squared difference over the noise of both.
pub(crate) fn noise_ratio(a: &Picture, b: &Picture) -> f64 {
    let count = a.halves[0].len();
    let sum: f64 = (0..count)
        .map(|i| a.value(i) - b.value(i))
        .map(|d| d * d)
        .sum();
    sum / count as f64 / (a.noise() + b.noise())
}

/// Render through the scene file, as any user's scene.
pub(crate) fn render(
    description: &SceneDescription,
    seed: u64,
    samples: u32,
    far_mesh: bool,
) -> Picture {
    let json = serde_json::to_vec(description).expect("JSON");
    let description = parse(&json).expect("within all ranges");
    let rect = TileRect {
        x0: 0,
        y0: 0,
        width: WIDTH,
        height: HEIGHT,
    };
    let settings = RenderSettings {
        width: WIDTH,
        height: HEIGHT,
        samples: 2,
        seed,
        frames: 1,
        first_frame: 0,
        stop: shearwater_shared::stop::Stop::NONE,
    };
    let assets = place::assets(far_mesh);
    let (scene, _) = Scene::build(&description, &assets, &settings, 0, BuildOptions::default())
        .expect("a scene that builds");
    let cancel = AtomicBool::new(false);
    let sums = render_run(&scene, &rect, 0..samples, &cancel).expect("not cancelled");
    assert_eq!(sums.bad.total(), 0, "{:?}", sums.bad);
    let mut film = TileFilm::zero(rect.pixels());
    film.add(&sums).expect("fits");
    let half = |half| {
        let pixels = 0..rect.pixels();
        pixels
            .flat_map(|pixel| film.half_mean(half, pixel))
            .collect()
    };
    Picture {
        halves: [half(0), half(1)],
    }
}
