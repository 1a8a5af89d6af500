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

// A density that jumps from 0 to 1 at `jump` of the way through, over a thousandth of
// the way; optical depth 2 per way.
fn jump_at(jump: f64) -> Volume {
    let voxels = 2000;
    let values = (0..voxels)
        .map(|i| f32::from(u8::from((f64::from(i) + 0.5) / f64::from(voxels) > jump)))
        .collect();
    cube(UVec3::new(voxels, 1, 1), values, 1.0)
}

// n jittered steps see a jump at the share f of their step as 0 with chance f: the
// mean of exp(-depth) exceeds the truth by (f + (1 - f) e^-a) e^(a (1 - f)), a = 2 / n.
#[test]
fn march_bias_at_a_jump() {
    let ray = Ray::new(Vec3::new(-5.0, 0.0, 0.0), Vec3::X);
    let mut table = "steps  bias of marching  closed form  bias of tracking\n".to_owned();
    for n in [1_u32, 4, 8, 16, 64] {
        let f = 0.37;
        let jump = (f64::from(n / 3) + f) / f64::from(n);
        let volume = jump_at(jump);
        // A hair more than the n-th part, or roundings make one step more.
        let media = marched(&volume, 2.0 / n as f32 * 1.000_001);
        let truth = libm::exp(-depth(&volume, &ray, f32::INFINITY));
        let (passed, error) = mean(200_000, |key| passes(&media, &ray, key));
        let a = 2.0 / f64::from(n);
        let expected = (f + (1.0 - f) * libm::exp(-a)) * libm::exp(a * (1.0 - f)) - 1.0;
        let bias = passed / truth - 1.0;
        let tracked = Media::new(vec![volume]);
        let (tracked, noise) = mean(200_000, |key| passes(&tracked, &ray, key));
        table += &format!(
            "{n:>5}  {:>+15.3} %  {:>+9.3} %  {:>+13.3} +- {:.3} %\n",
            bias * 100.0,
            expected * 100.0,
            (tracked / truth - 1.0) * 100.0,
            noise / truth * 100.0
        );
        let slack = 5.0 * error / truth + 1e-3;
        assert!((bias - expected).abs() < slack, "{n}: {bias}, {expected}");
        assert!((tracked / truth - 1.0).abs() < 5.0 * noise / truth + 1e-5);
    }
    println!("{table}");
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
