//! What a sky must look like, by order and ratio.

use super::spectrum::luminance;
use super::*;

fn sky(turbidity: f64) -> AtmosphereSky {
    AtmosphereSky {
        turbidity,
        ground_albedo: 0.1,
        intensity: 1.0,
    }
}

fn sun(elevation_deg: f64) -> Sun {
    Sun {
        azimuth_deg: 0.0,
        elevation_deg,
        angular_radius_deg: 0.27,
        radiance: None,
    }
}

// The texel at a bearing and elevation in degrees.
fn at(map: &[[f32; 3]], bearing: f64, elevation: f64) -> [f64; 3] {
    let column = ((bearing / 360.0 + 0.5) * WIDTH as f64) as usize % WIDTH;
    let row = ((90.0 - elevation) / 180.0 * HEIGHT as f64) as usize;
    map[row.min(HEIGHT - 1) * WIDTH + column].map(f64::from)
}

// Irradiance of level ground by the sky's map.
fn irradiance(map: &[[f32; 3]]) -> [f64; 3] {
    let mut sum = [0.0; 3];
    for row in 0..HEIGHT / 2 {
        let theta = PI * (row as f64 + 0.5) / HEIGHT as f64;
        let weight = libm::sin(theta) * libm::cos(theta) * 2.0 * PI * PI / (WIDTH * HEIGHT) as f64;
        for texel in &map[row * WIDTH..(row + 1) * WIDTH] {
            for (sum, v) in sum.iter_mut().zip(texel) {
                *sum += weight * f64::from(*v);
            }
        }
    }
    sum
}

// Irradiance of level ground by the sun's disc.
fn by_sun(sky: &AtmosphereSky, sun: &Sun) -> [f64; 3] {
    let half = libm::sin(sun.angular_radius_deg.to_radians() * 0.5);
    let omega = 4.0 * PI * half * half;
    let cos = libm::sin(sun.elevation_deg.to_radians());
    sun_radiance(sky, sun).map(|v| f64::from(v) * omega * cos)
}

fn blue_over_red([r, _, b]: [f64; 3]) -> f64 {
    b / r
}

#[test]
fn noon_is_blue_above_and_pale_at_the_horizon() {
    let map = sky_map(&sky(2.5), &sun(60.0));
    let (zenith, horizon) = (at(&map, 180.0, 89.0), at(&map, 180.0, 1.0));
    assert!(
        blue_over_red(zenith) > 1.3 * blue_over_red(horizon),
        "{zenith:?} {horizon:?}"
    );
    assert!(luminance(horizon) > luminance(zenith));
    assert!(blue_over_red(at(&map, 180.0, 60.0)) > 1.7);
    // The real sky: some thousand candelas per square metre.
    assert!((0.1..2.0).contains(&luminance(zenith)), "{zenith:?}");
}

#[test]
fn the_low_sun_is_orange_and_reddens_the_horizon() {
    for elevation in [2.0, 5.0] {
        let map = sky_map(&sky(2.5), &sun(elevation));
        let (zenith, horizon) = (at(&map, 0.0, 89.0), at(&map, 8.0, 0.5));
        assert!(
            blue_over_red(horizon) < 0.3 * blue_over_red(zenith),
            "{elevation}: {horizon:?} {zenith:?}"
        );
        let away = at(&map, 180.0, 10.0);
        assert!(blue_over_red(away) > 2.0 * blue_over_red(horizon));
        let [r, g, b] = sun_radiance(&sky(2.5), &sun(elevation));
        assert!(r > 1.5 * g && g > 2.0 * b, "{elevation}: {r} {g} {b}");
    }
    let [r, _, b] = sun_radiance(&sky(2.5), &sun(60.0));
    assert!(r < 2.0 * b, "the high sun is nearly white: {r} {b}");
}

// Twilight: all light is gone but the sky's, it fades as the sun sinks, and the
// horizon under which the sun went is the brightest and the reddest.
#[test]
fn dusk_fades() {
    let mut before = f64::INFINITY;
    for elevation in [3.0, 0.0, -3.0, -6.0, -12.0] {
        let map = sky_map(&sky(2.5), &sun(elevation));
        let light = luminance(irradiance(&map));
        assert!(light > 0.0 && light < 0.6 * before, "{elevation}: {light}");
        before = light;
        let (towards, away) = (at(&map, 0.0, 2.0), at(&map, 180.0, 2.0));
        assert!(luminance(towards) > luminance(away));
        if elevation < -1.0 {
            assert!(blue_over_red(towards) < blue_over_red(at(&map, 0.0, 80.0)));
            assert_eq!(sun_radiance(&sky(2.5), &sun(elevation)), [0.0; 3]);
        }
    }
}

// No more light reaches the ground than enters above it, and it grows with the
// sun's height. At the lowest sun light from beyond the horizon counts too.
#[test]
fn energy_is_kept() {
    let outside = luminance(to_rgb(&SOLAR, &matching_rgb()));
    // 683 lm/W times the visible part of the solar constant: 128 to 137 klx.
    assert!((12.8..13.8).contains(&outside), "{outside}");
    for turbidity in [1.0, 2.5, 6.0] {
        let mut before = 0.0;
        for elevation in [2.0, 10.0, 30.0, 60.0, 90.0] {
            let (sky, sun) = (sky(turbidity), sun(elevation));
            let above = irradiance(&sky_map(&sky, &sun));
            let light = luminance(above) + luminance(by_sun(&sky, &sun));
            let entering = outside * libm::sin(elevation.to_radians());
            assert!(
                light < entering + 0.02 * outside,
                "turbidity {turbidity}, elevation {elevation}: {light} of {entering}"
            );
            assert!(
                light > before,
                "turbidity {turbidity}, elevation {elevation}"
            );
            before = light;
        }
        // Clear air lets most of it through.
        assert!(before > 0.7 * outside, "turbidity {turbidity}: {before}");
    }
}

#[test]
fn haze_makes_an_aureole_and_dims_the_sun() {
    let aureole = |turbidity| {
        let map = sky_map(&sky(turbidity), &sun(40.0));
        luminance(at(&map, 0.0, 42.0)) / luminance(at(&map, 180.0, 50.0))
    };
    let (air, some, much) = (aureole(1.0), aureole(3.0), aureole(6.0));
    assert!(some > 5.0 * air && much > 5.0 * air, "{air} {some} {much}");
    let disc = |turbidity| sun_radiance(&sky(turbidity), &sun(40.0))[1];
    assert!(disc(1.0) > disc(3.0) && disc(3.0) > disc(6.0));
}

// The smaller the disc, the brighter: the light is the same.
#[test]
fn the_sun_gives_the_same_light_at_any_size() {
    let mut small = sun(30.0);
    small.angular_radius_deg = 0.05;
    let (a, b) = (by_sun(&sky(2.0), &sun(30.0)), by_sun(&sky(2.0), &small));
    assert!((a[1] / b[1] - 1.0).abs() < 1e-4, "{a:?} {b:?}");
}

// Neighbouring texels differ little everywhere above the horizon, but for the
// aureole: no rings, no edge where the earth's shadow ends.
#[test]
fn the_sky_is_smooth() {
    for elevation in [30.0, 3.0, -3.0] {
        let map = sky_map(&sky(2.5), &sun(elevation));
        let bright = luminance(at(&map, 0.0, 5.0));
        for row in 1..HEIGHT / 2 - 1 {
            for column in (0..WIDTH).step_by(8) {
                let v = |row: usize| luminance(map[row * WIDTH + column].map(f64::from));
                let (a, b, c) = (v(row - 1), v(row), v(row + 1));
                assert!(
                    (a - 2.0 * b + c).abs() < 0.05 * b + 1e-3 * bright,
                    "{elevation}, row {row}, column {column}: {a} {b} {c}"
                );
            }
        }
    }
}

#[test]
fn turning_the_sun_turns_the_sky() {
    let straight = sky_map(&sky(2.5), &sun(5.0));
    let mut turned = sun(5.0);
    turned.azimuth_deg = -270.0 + 3600.0;
    let map = sky_map(&sky(2.5), &turned);
    for (bearing, elevation) in [(0.0, 3.0), (77.0, 20.0), (180.0, 50.0)] {
        let (a, b) = (
            at(&straight, bearing, elevation),
            at(&map, bearing + 90.0, elevation),
        );
        assert!((a[0] / b[0] - 1.0).abs() < 1e-4, "{a:?} {b:?}");
    }
}

#[test]
fn threads_leave_no_trace() {
    let map = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        pool.expect("threads")
            .install(|| sky_map(&sky(4.0), &sun(12.0)))
    };
    assert!(map(1) == map(3));
}
