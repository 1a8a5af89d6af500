//! The sky, the sun and what they light.

use crate::common::{
    LAMP_RADIANCE, LAMP_SIZE, LAMP_TEXEL, WHITE_SKY, assert_mean, floor, mean_and_error, scene,
};
use glam::Vec3;
use shearwater_tracer::BuildOptions;
use shearwater_tracer::bsdf::{Bsdf, GgxModel, GgxParameters, TableNeeds, Tables};
use shearwater_tracer::light::SunLight;
use shearwater_tracer::math::hash::u32_to_unit;
use shearwater_tracer::sampler::sobol4_owen;

#[test]
fn the_sky_is_what_it_says() {
    let body = r#""sky":{"type":"constant","radiance":[0.25,1,1]}"#;
    let scene = scene(
        body,
        [0.0, 5.0, 0.0],
        [1.0, 6.0, 0.0],
        40.0,
        1,
        BuildOptions::default(),
    );
    assert_mean("sky", &scene, 4, 0.25);
}

#[test]
fn the_sun_itself_has_its_radiance() {
    let body =
        r#""sun":{"azimuth_deg":0,"elevation_deg":0.5,"angular_radius_deg":5,"radiance":[7,7,7]}"#;
    let scene = scene(
        body,
        [0.0, 2.0, 0.0],
        [0.0, 2.0, -1.0],
        2.0,
        5,
        BuildOptions::default(),
    );
    assert_mean("sun disc", &scene, 4, 7.0);
}

// A mirror-like floor that shows the sun: BSDF sampling and light sampling
// must share it without counting it twice, at any roughness.
#[test]
fn a_glossy_floor_reflects_the_sun_once() {
    for roughness in [0.05, 0.2, 0.5] {
        let material = format!(
            r#"{{"type":"ggx","base_color":[1,1,1],"metalness":1,"roughness":{roughness}}}"#
        );
        let sky = format!("{},{WHITE_SKY}", floor(&material));
        // A sun of 45 degrees over the mirror direction, a sky everywhere: the sun's
        // light alone is the difference of the two pictures.
        let sun = r#""sun":{"azimuth_deg":0,"elevation_deg":45,"angular_radius_deg":8,"radiance":[1,1,1]}"#;
        let with = scene(
            &format!("{sky},{sun}"),
            [0.0, 5.0, 5.0],
            [0.0; 3],
            3.0,
            6,
            BuildOptions::default(),
        );
        let without = scene(
            &sky,
            [0.0, 5.0, 5.0],
            [0.0; 3],
            3.0,
            7,
            BuildOptions::default(),
        );
        let ((a, ea), (b, eb)) = (mean_and_error(&with, 512), mean_and_error(&without, 512));
        // Both are part of a furnace of 2 at the most; a smooth mirror shows 1 more.
        assert!(
            a - b <= 1.0 + 5.0 * (ea + eb),
            "roughness {roughness}: {a} - {b}"
        );
        if roughness < 0.1 {
            assert!(
                (a - b - 1.0).abs() < 0.02,
                "roughness {roughness}: {a} - {b}"
            );
        }
    }
}

// The bilinear lamp over a Lambert floor: E = sum of L cos over the map, by a fine
// quadrature here, by sampling the sky and the surface with their weights there.
#[test]
fn an_uneven_sky_lights_a_floor_as_its_integral_says() {
    let sky = r#""sky":{"type":"map","file":"lamp.exr"}"#;
    let [width, height] = LAMP_SIZE.map(|n| n as f64);
    let fine = 40;
    let mut irradiance = 0.0;
    for j in 0..LAMP_SIZE[1] / 2 * fine {
        let v = (j as f64 + 0.5) / (height * fine as f64);
        let theta = std::f64::consts::PI * v;
        let hat = |x: f64, centre: usize| (1.0 - (x - centre as f64 - 0.5).abs()).max(0.0);
        let ring = 2.0 * std::f64::consts::PI * std::f64::consts::PI / (height * fine as f64);
        // The hat in u integrates to one texel of the row.
        let lamp = (f64::from(LAMP_RADIANCE) - 0.1) * hat(v * height, LAMP_TEXEL[1]) / width;
        irradiance += (0.1 + lamp) * libm::sin(theta) * libm::cos(theta) * ring;
    }
    for (material, reflectance, what) in [
        (
            r#"{"type":"lambert","albedo":[0.5,0.5,0.5]}"#,
            0.5 / std::f64::consts::PI,
            "lambert",
        ),
        (
            r#"{"type":"phong","kd":[0.5,0.5,0.5],"ks":[0,0,0],"exponent":10}"#,
            0.5 / std::f64::consts::PI,
            "phong",
        ),
    ] {
        let body = format!("{},{sky}", floor(material));
        let scene = scene(
            &body,
            [0.0, 2.0, 0.01],
            [0.0; 3],
            20.0,
            15,
            BuildOptions::default(),
        );
        assert_mean(what, &scene, 512, reflectance * irradiance);
    }
}

// A rough metal under a wide sun and nothing else: light sampling and the surface's
// own directions share the work, and must give what light sampling gives alone.
#[test]
fn a_rough_metal_reflects_the_sun_as_its_integral_says() {
    let json = r#"{"azimuth_deg":0,"elevation_deg":45,"angular_radius_deg":40,"radiance":[1,1,1]}"#;
    let sun: shearwater_shared::scene::Sun = serde_json::from_str(json).expect("a sun");
    let light = SunLight::new(&sun).expect("light");
    let tables = Tables::build(&TableNeeds {
        schlick: true,
        etas: Vec::new(),
        ..TableNeeds::default()
    })
    .expect("tables");
    for roughness in [0.2, 0.4, 0.6, 0.9f32] {
        let material = format!(
            r#"{{"type":"ggx","base_color":[1,1,1],"metalness":1,"roughness":{roughness}}}"#
        );
        let body = format!(r#"{},"sun":{json}"#, floor(&material));
        let scene = scene(
            &body,
            [0.0, 5.0, 5.0],
            [0.0; 3],
            0.2,
            16,
            BuildOptions::default(),
        );
        let (mean, error) = mean_and_error(&scene, 2048);
        let parameters = GgxParameters {
            base_color: Vec3::ONE,
            metalness: 1.0,
            alpha: roughness * roughness,
            ..GgxParameters::default()
        };
        let ggx = Bsdf::ggx(&tables, GgxModel::Corrected, &parameters).expect("in range");
        // The local z is the world's y; any turn about it will do.
        let local = |w: Vec3| Vec3::new(w.x, w.z, w.y);
        let wo = local(Vec3::new(0.0, 1.0, 1.0).normalize());
        let n = 1 << 18;
        let sum: f64 = (0..n)
            .map(|i| {
                let u = sobol4_owen(i, 5, 6).map(u32_to_unit);
                f64::from(
                    ggx.eval_pdf(&tables, wo, local(light.sample([u[0], u[1]])))
                        .0
                        .x,
                )
            })
            .sum();
        let expected = sum / f64::from(n) / f64::from(light.pdf());
        assert!(
            (mean - expected).abs() < 5.0 * error + 2e-3 * expected,
            "{roughness}: {mean} +- {error}, expected {expected}"
        );
    }
}
