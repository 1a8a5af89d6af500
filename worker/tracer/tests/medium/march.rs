//! Marching and how wrong it is.

use crate::common::{cube, depth, lumpy, mean, passes, rays, survives};
use glam::{UVec3, Vec3};
use shearwater_tracer::geometry::Ray;
use shearwater_tracer::medium::{Media, Method, Volume};

fn marched(volume: &Volume, step_m: f32) -> Media {
    Media::new(vec![Volume {
        method: Method::March { step_m },
        ..volume.clone()
    }])
}

// Through lumps the bias is upwards and falls with the square of the step; paths
// (which invert the depth) have the same one as shadow rays.
#[test]
fn march_bias_through_lumps() {
    let volume = lumpy(20.0, 3);
    let mut table = "step_m  bias of marching over 40 rays\n".to_owned();
    let mut biases = Vec::new();
    for step_m in [0.8_f32, 0.4, 0.2, 0.1, 0.05] {
        let media = marched(&volume, step_m);
        let (mut bias, mut paths, mut truth) = (0.0, 0.0, 0.0);
        for ray in rays(40) {
            let exact = libm::exp(-depth(&volume, &ray, f32::INFINITY));
            bias += mean(4000, |key| passes(&media, &ray, key)).0 - exact;
            paths += mean(4000, |key| survives(&media, &ray, f32::INFINITY, key)).0 - exact;
            truth += exact;
        }
        table += &format!("{step_m:>6}  {:>+8.3} %\n", bias / truth * 100.0);
        biases.push(bias / truth);
        assert!(
            ((paths - bias) / truth).abs() < 0.03,
            "{step_m}: {paths} {bias}"
        );
    }
    println!("{table}");
    assert!(biases[0] > 0.05, "{biases:?}");
    assert!(
        biases[0] > 3.0 * biases[2] && biases[2] > 3.0 * biases[4],
        "{biases:?}"
    );
    assert!(biases[4].abs() < 0.01, "{biases:?}");
}

// An even density has no variance, hence no bias.
#[test]
fn marching_an_even_volume_is_exact() {
    let even = cube(UVec3::ONE, vec![1.0], 1.5);
    let ray = Ray::new(Vec3::new(-5.0, 0.3, 0.1), Vec3::X);
    for step_m in [0.07, 0.5, 10.0] {
        let passed = passes(&marched(&even, step_m), &ray, 9);
        assert!(
            (passed - libm::exp(-3.0)).abs() < 1e-6,
            "{step_m}: {passed}"
        );
    }
}
