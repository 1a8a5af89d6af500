//! Tracking against closed forms and numeric integrals.

use crate::common::{assert_near, ball, depth, lumpy, lumpy_over, mean, passes, rays, survives};
use glam::Vec3;
use shearwater_tracer::geometry::Ray;
use shearwater_tracer::medium::{Media, Volume};

fn media(volumes: impl IntoIterator<Item = Volume>) -> Media {
    Media::new(volumes.into_iter().collect())
}

// Ratio tracking (shadow rays), delta tracking (paths), and where the latter stops,
// against the integral along the ray. The densest has a transmittance of 0.01, where
// shadow rays play roulette.
#[test]
fn uneven_volumes_pass_what_the_integral_says() {
    for (base, sigma, seed) in [(0.0, 2.0, 1), (0.0, 8.0, 2), (0.0, 40.0, 3), (0.2, 3.0, 4)] {
        let volume = lumpy_over(base, sigma, seed * 7919);
        let media = media([volume.clone()]);
        for (number, ray) in rays(6).enumerate() {
            let what = format!("{sigma} {number}");
            let expected = libm::exp(-depth(&volume, &ray, f32::INFINITY));
            let ratio = mean(40_000, |key| passes(&media, &ray, key));
            assert_near(&format!("ratio {what}"), ratio, expected);
            let delta = mean(40_000, |key| survives(&media, &ray, f32::INFINITY, key));
            assert_near(&format!("delta {what}"), delta, expected);
            let half = libm::exp(-depth(&volume, &ray, 5.0));
            let limited = mean(40_000, |key| survives(&media, &ray, 5.0, key));
            assert_near(&format!("up to a surface {what}"), limited, half);
        }
    }
}

#[test]
fn a_ray_may_begin_inside() {
    let volume = lumpy(6.0, 11);
    let inside = Ray::new(Vec3::new(0.1, 0.2, -0.3), Vec3::new(0.6, 0.0, 0.8));
    let media = media([volume.clone()]);
    let expected = libm::exp(-depth(&volume, &inside, f32::INFINITY));
    assert_near(
        "ratio",
        mean(40_000, |key| passes(&media, &inside, key)),
        expected,
    );
    let backwards = Ray::new(Vec3::new(0.0, 0.0, 9.0), Vec3::Z);
    assert_eq!(passes(&media, &backwards, 1), 1.0);
    assert_eq!(media.collide(&backwards, f32::INFINITY, 1), Ok(None));
}

#[test]
fn overlapping_volumes_act_as_their_sum() {
    let (one, two, three) = (lumpy(6.0, 1), lumpy(3.0, 2), ball(0.4));
    let all = media([one.clone(), two.clone(), three.clone()]);
    for (number, ray) in rays(4).enumerate() {
        let total: f64 = [&one, &two, &three]
            .map(|v| depth(v, &ray, f32::INFINITY))
            .iter()
            .sum();
        let what = format!("{number}");
        let ratio = mean(40_000, |key| passes(&all, &ray, key));
        assert_near(&what, ratio, libm::exp(-total));
        let delta = mean(40_000, |key| survives(&all, &ray, f32::INFINITY, key));
        assert_near(&what, delta, libm::exp(-total));
        // And where: before 5 m with the chance of the sum.
        let near: f64 = [&one, &two, &three]
            .map(|v| depth(v, &ray, 5.0))
            .iter()
            .sum();
        let before = mean(40_000, |key| {
            let met = all.collide(&ray, f32::INFINITY, key).expect("few steps");
            f64::from(u8::from(met.is_none_or(|c| c.t > 5.0)))
        });
        assert_near(&what, before, libm::exp(-near));
    }
}

#[test]
fn draws_follow_the_key_alone() {
    let media = media([lumpy(8.0, 5), ball(0.5)]);
    for ray in rays(50) {
        let one = media.collide(&ray, f32::INFINITY, 77);
        assert_eq!(one, media.collide(&ray, f32::INFINITY, 77));
        // A nearer limit changes nothing before it.
        if let Ok(Some(collision)) = one {
            let limit = collision.t.next_up();
            assert_eq!(media.collide(&ray, limit, 77), one);
            assert_eq!(media.collide(&ray, collision.t * 0.999, 77), Ok(None));
        }
    }
}
