//! Whole scenes whose radiance is known: the tracer from scene.json to sums.

use glam::Vec3;
use shearwater_shared::film::{TileFilm, TileSums};
use shearwater_shared::job::RenderSettings;
use shearwater_shared::plan::TileRect;
use shearwater_shared::scene::parse;
use shearwater_tracer::bsdf::{Bsdf, GgxModel, GgxParameters, TableNeeds, Tables};
use shearwater_tracer::light::SunLight;
use shearwater_tracer::math::hash::u32_to_unit;
use shearwater_tracer::sampler::sobol4_owen;
use shearwater_tracer::{Assets, BuildOptions, Scene, render_run};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

const SIDE: u32 = 16;
const RECT: TileRect = TileRect {
    x0: 0,
    y0: 0,
    width: SIDE,
    height: SIDE,
};
const FLOOR: &str = "v -1e4 0 -1e4\nv -1e4 0 1e4\nv 1e4 0 1e4\nv 1e4 0 -1e4\nf 1 2 3 4\n";

/// The lower half of a sphere of radius 1, open to the sky, its faces inwards.
fn bowl() -> Vec<u8> {
    let (rings, sectors) = (48, 96);
    let mut text = String::from("v 0 -1 0\n");
    for ring in 1..=rings {
        let polar = std::f64::consts::FRAC_PI_2 * f64::from(ring) / f64::from(rings);
        for sector in 0..sectors {
            let around = 2.0 * std::f64::consts::PI * f64::from(sector) / f64::from(sectors);
            let (x, z) = (
                libm::sin(polar) * libm::cos(around),
                libm::sin(polar) * libm::sin(around),
            );
            text.push_str(&format!("v {x} {} {z}\n", -libm::cos(polar)));
        }
    }
    let at = |ring: i32, sector: i32| 2 + (ring - 1) * sectors + sector % sectors;
    for sector in 0..sectors {
        text.push_str(&format!("f 1 {} {}\n", at(1, sector), at(1, sector + 1)));
        for ring in 1..rings {
            let (a, b) = (at(ring, sector), at(ring, sector + 1));
            let (c, d) = (at(ring + 1, sector + 1), at(ring + 1, sector));
            text.push_str(&format!("f {a} {d} {c} {b}\n"));
        }
    }
    text.into_bytes()
}

/// A dim sky with one bright texel 45 degrees above the horizon at -z.
fn lamp() -> Vec<u8> {
    use exr::prelude::{SpecificChannels, WritableImage};
    let (width, height) = (LAMP_SIZE[0], LAMP_SIZE[1]);
    let pixel = |at: exr::math::Vec2<usize>| {
        let v = if [at.x(), at.y()] == LAMP_TEXEL {
            LAMP_RADIANCE
        } else {
            0.1
        };
        (v, v, v)
    };
    let mut bytes = Vec::new();
    let channels = SpecificChannels::rgb(pixel);
    let image = exr::image::Image::from_channels((width, height), channels);
    image
        .write()
        .to_buffered(std::io::Cursor::new(&mut bytes))
        .expect("an EXR");
    bytes
}

const LAMP_SIZE: [usize; 2] = [64, 32];
const LAMP_TEXEL: [usize; 2] = [32, 7];
const LAMP_RADIANCE: f32 = 2000.0;

/// A scene of `body` (JSON members) seen by a camera of `fov` degrees at `eye`
/// that looks at `target`; `floor.obj` is a square of 20 km at y = 0.
fn scene(
    body: &str,
    eye: [f64; 3],
    target: [f64; 3],
    fov: f64,
    seed: u64,
    options: BuildOptions,
) -> Scene {
    let up = if eye[0] == target[0] && eye[2] == target[2] {
        "[0,0,-1]"
    } else {
        "[0,1,0]"
    };
    let json = format!(
        r#"{{"version":1,"name":"test","image":{{"width":{SIDE},"height":{SIDE}}},
        "camera":{{"position_m":{eye:?},"target_m":{target:?},"up":{up},"vertical_fov_deg":{fov:?},"shutter_s":0.01}},
        "meshes":{{"floor":{{"file":"floor.obj"}},"bowl":{{"file":"bowl.obj","normals":"flat"}}}},{body}}}"#
    );
    let description = parse(json.as_bytes()).expect("a valid scene");
    let files = [
        ("floor.obj", FLOOR.as_bytes().to_vec()),
        ("bowl.obj", bowl()),
        ("lamp.exr", lamp()),
    ];
    let assets: Assets = files
        .map(|(name, bytes)| (name.to_owned(), Arc::from(bytes)))
        .into();
    let settings = RenderSettings {
        width: SIDE,
        height: SIDE,
        samples: 2,
        seed,
        frames: 1,
    };
    Scene::build(&description, &assets, &settings, 0, options)
        .expect("a scene that builds")
        .0
}

fn sums(scene: &Scene, samples: std::ops::Range<u32>) -> TileSums {
    let sums =
        render_run(scene, &RECT, samples.clone(), &AtomicBool::new(false)).expect("not cancelled");
    sums.check(&RECT, &samples)
        .expect("sums of the right shape");
    assert_eq!(sums.bad.total(), 0, "{:?}", sums.bad);
    sums
}

/// Mean of the red channel and its standard error, the latter from the halves.
fn mean_and_error(scene: &Scene, samples: u32) -> (f64, f64) {
    let mut film = TileFilm::zero(RECT.pixels());
    film.add(&sums(scene, 0..samples)).expect("fits");
    let pixels = RECT.pixels();
    let (mut mean, mut variance) = (0.0, 0.0);
    for pixel in 0..pixels {
        let (a, b) = (film.half_mean(0, pixel)[0], film.half_mean(1, pixel)[0]);
        mean += (a + b) / 2.0;
        variance += (a - b) * (a - b) / 4.0;
    }
    (mean / pixels as f64, variance.sqrt() / pixels as f64)
}

// Five standard errors: one false alarm in 2 million; seeds are fixed besides.
fn assert_mean(what: &str, scene: &Scene, samples: u32, expected: f64) {
    let (mean, error) = mean_and_error(scene, samples);
    let tolerance = 5.0 * error + 1e-4 * expected;
    assert!(
        (mean - expected).abs() <= tolerance,
        "{what}: {mean} +- {error}, expected {expected}"
    );
    assert!(
        error < 0.02 * expected.max(0.05),
        "{what}: too noisy to tell, {error}"
    );
}

const WHITE_SKY: &str = r#""sky":{"type":"constant","radiance":[1,1,1]}"#;

fn floor(material: &str) -> String {
    format!(r#""materials":{{"m":{material}}},"instances":[{{"mesh":"floor","material":"m"}}]"#)
}

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

// A plane that sees the whole upper half of a white sky reflects its albedo.
#[test]
fn a_lambert_floor_under_a_white_sky_has_its_albedo() {
    let body = format!(
        "{},{WHITE_SKY}",
        floor(r#"{"type":"lambert","albedo":[0.6,0.6,0.6]}"#)
    );
    let scene = scene(
        &body,
        [0.0, 2.0, 0.0],
        [0.0, 0.0, 0.0],
        40.0,
        2,
        BuildOptions::default(),
    );
    assert_mean("lambert", &scene, 64, 0.6);
}

// The dielectric with an energy-conserving body is exactly white.
#[test]
fn a_white_ggx_floor_under_a_white_sky_is_white() {
    for roughness in [0.05, 0.4, 0.9] {
        let ggx = format!(r#"{{"type":"ggx","base_color":[1,1,1],"roughness":{roughness}}}"#);
        let body = format!("{},{WHITE_SKY}", floor(&ggx));
        for (eye, angle) in [([0.0, 3.0, 0.01], 0), ([0.0, 1.0, 6.0], 80)] {
            let scene = scene(&body, eye, [0.0; 3], 5.0, 3, BuildOptions::default());
            assert_mean(
                &format!("ggx {roughness} at {angle} degrees"),
                &scene,
                256,
                1.0,
            );
        }
    }
}

// Radiance = albedo / pi * E, E = pi L sin^2(r) cos(zenith): by next event
// estimation for rough surfaces.
#[test]
fn the_sun_lights_a_floor_exactly() {
    for (elevation, irradiance) in [(90.0, 69.763_606), (30.0, 34.881_803), (10.0, 12.114_323)] {
        let sun = format!(
            r#""sun":{{"azimuth_deg":40,"elevation_deg":{elevation},"radiance":[1e6,1e6,1e6]}}"#
        );
        let body = format!(
            "{},{sun}",
            floor(r#"{"type":"lambert","albedo":[0.5,0.5,0.5]}"#)
        );
        let scene = scene(
            &body,
            [0.0, 2.0, 0.0],
            [0.0, 0.0, 0.0],
            20.0,
            4,
            BuildOptions::default(),
        );
        assert_mean(
            &format!("sun at {elevation}"),
            &scene,
            64,
            0.5 / std::f64::consts::PI * irradiance,
        );
    }
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

// Inside a sphere every point sees every other alike, so the radiance of the bowl
// is the same everywhere: half its light comes from the sky, half from itself,
// L = rho / 2 (1 + L). Paths are long and end by Russian roulette.
#[test]
fn a_bowl_under_a_white_sky_has_its_closed_form() {
    for rho in [0.5, 0.9, 0.99] {
        let body = format!(
            r#""materials":{{"m":{{"type":"lambert","albedo":[{rho},{rho},{rho}]}}}},
            "instances":[{{"mesh":"bowl","material":"m"}}],{WHITE_SKY}"#
        );
        let scene = scene(
            &body,
            [0.0, 0.5, 0.01],
            [0.0, -1.0, 0.0],
            20.0,
            14,
            BuildOptions::default(),
        );
        let (mean, error) = mean_and_error(&scene, 512);
        let expected = 0.5 * rho / (1.0 - 0.5 * rho);
        // The facets leave out 0.1 % of the sphere.
        assert!(
            (mean - expected).abs() < 5.0 * error + 2e-3 * expected,
            "{rho}: {mean} +- {error}, {expected}"
        );
        assert!(error < 0.01 * expected, "{rho}: {error}");
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

const CLOUD: &str = r#""centre_m":[0,0,0],"radii_m":[2,2,2],"direction":[1,0,0],"length_m":1,"particle_radius_m":[0.5,1.5]"#;

// Nothing is absorbed and light comes from everywhere: the cloud is invisible.
#[test]
fn a_white_cloud_in_a_white_furnace_is_invisible() {
    for opacity in [0.1, 0.5, 1.0] {
        let cloud = format!(
            r#""clouds":[{{{CLOUD},"count":60,"opacity":[{opacity},{opacity}],"albedo":[1,1,1]}}]"#
        );
        let body = format!("{cloud},{WHITE_SKY}");
        let scene = scene(
            &body,
            [0.0, 0.0, 9.0],
            [0.0; 3],
            30.0,
            8,
            BuildOptions::default(),
        );
        assert_mean(&format!("cloud of opacity {opacity}"), &scene, 256, 1.0);
    }
}

// k black particles of one place: each is crossed twice, T = (1 - a)^(2 k), and
// passing through costs no depth.
#[test]
fn black_layers_transmit_their_power() {
    for (count, opacity) in [(1u32, 0.5f64), (10, 0.1), (500, 0.002), (1000, 0.0005)] {
        let cloud = format!(
            r#""clouds":[{{"centre_m":[0,0,0],"radii_m":[1e-4,1e-4,1e-4],"direction":[1,0,0],"length_m":0,"count":{count},
            "particle_radius_m":[1,1],"opacity":[{opacity},{opacity}],"albedo":[0,0,0]}}]"#
        );
        let scene = scene(
            &format!("{cloud},{WHITE_SKY}"),
            [0.0, 0.0, 9.0],
            [0.0; 3],
            4.0,
            9,
            BuildOptions::default(),
        );
        let expected = libm::pow(1.0 - opacity, 2.0 * f64::from(count));
        assert_mean(
            &format!("{count} layers of {opacity}"),
            &scene,
            1024,
            expected,
        );
    }
}

// The same transmittance, seen by a shadow ray: a floor under the particles lit
// by the sun from straight above.
#[test]
fn shadows_of_layers_transmit_the_same() {
    let sun = r#""sun":{"azimuth_deg":0,"elevation_deg":90,"angular_radius_deg":0.1,"radiance":[1e6,1e6,1e6]}"#;
    let cloud = r#""clouds":[{"centre_m":[0,50,0],"radii_m":[1e-4,1e-4,1e-4],"direction":[1,0,0],"length_m":0,"count":20,
        "particle_radius_m":[5,5],"opacity":[0.03,0.03],"albedo":[0,0,0]}]"#;
    let ground = floor(r#"{"type":"lambert","albedo":[0.5,0.5,0.5]}"#);
    let eye = [3.0, 10.0, 0.0];
    let lit = scene(
        &format!("{ground},{sun}"),
        eye,
        [0.0; 3],
        4.0,
        10,
        BuildOptions::default(),
    );
    let dimmed = scene(
        &format!("{ground},{sun},{cloud}"),
        eye,
        [0.0; 3],
        4.0,
        10,
        BuildOptions::default(),
    );
    let ((full, _), (part, error)) = (mean_and_error(&lit, 16), mean_and_error(&dimmed, 16));
    let expected = full * libm::pow(0.97, 40.0);
    assert!(
        (part - expected).abs() < 5.0 * error + 1e-3 * expected,
        "{part}, expected {expected}"
    );
}

// Water in a white furnace: never brighter than 1, and what bumped normals lose
// below the surface stays small, down to 1 degree of elevation.
#[test]
fn water_in_a_white_furnace_loses_little_and_gains_nothing() {
    let water = r#""water":{"type":"tessendorf","tile_m":100,"wind_speed_mps":8,"cutoff_m":0.5,"body_color":[1,1,1],"roughness":0.1}"#;
    for (height, angle) in [(20.0, 20.0f64), (5.0, 5.0), (1.0, 1.0)] {
        let distance = height / libm::tan(angle.to_radians());
        let eye = [0.0, height, distance];
        let scene = scene(
            &format!("{water},{WHITE_SKY}"),
            eye,
            [0.0; 3],
            0.5,
            11,
            BuildOptions::default(),
        );
        let (mean, error) = mean_and_error(&scene, 256);
        assert!(
            mean <= 1.0 + 5.0 * error + 1e-4,
            "{angle} degrees: {mean} +- {error}"
        );
        assert!(mean > 0.9, "{angle} degrees: {mean}");
        println!("water at {angle} degrees: {mean:.5} +- {error:.5}");
    }
}

// During the shutter the water drifts and nothing else: without water the
// picture is that of a closed shutter, bit for bit; with it, it is not.
#[test]
fn the_shutter_blurs_the_water_only() {
    let sums_of = |body: &str, shutter: f64| {
        let json = format!(
            r#"{{"version":1,"name":"t","image":{{"width":{SIDE},"height":{SIDE}}},"camera":{{"position_m":[0,3,12],
            "target_m":[0,0,0],"vertical_fov_deg":50,"shutter_s":{shutter:?}}},{body},{WHITE_SKY}}}"#
        );
        let description = parse(json.as_bytes()).expect("a valid scene");
        let settings = RenderSettings {
            width: SIDE,
            height: SIDE,
            samples: 2,
            seed: 1,
            frames: 1,
        };
        let options = BuildOptions::default();
        let scene = Scene::build(&description, &Assets::new(), &settings, 0, options)
            .expect("a scene")
            .0;
        sums(&scene, 0..4).radiance
    };
    let sun =
        r#""sun":{"azimuth_deg":0,"elevation_deg":15,"angular_radius_deg":5,"radiance":[9,9,9]}"#;
    let water = |v: f64| {
        format!(
            r#"{sun},"water":{{"type":"tessendorf","tile_m":20,"wind_speed_mps":6,"velocity_mps":[0,{v:?}]}}"#
        )
    };
    let cloud = format!(r#""clouds":[{{{CLOUD},"count":9,"opacity":[0.5,0.5]}}]"#);
    assert_eq!(sums_of(&cloud, 0.5), sums_of(&cloud, 0.0));
    assert_eq!(sums_of(&water(0.0), 0.5), sums_of(&water(0.0), 0.0));
    assert_eq!(sums_of(&water(3.0), 0.0), sums_of(&water(0.0), 0.0));
    assert_ne!(sums_of(&water(3.0), 0.5), sums_of(&water(0.0), 0.5));
}

fn everything() -> String {
    let water = r#""water":{"type":"tessendorf","height_m":-1,"tile_m":50,"wind_speed_mps":8,"velocity_mps":[0,40]}"#;
    let sun = r#""sun":{"azimuth_deg":20,"elevation_deg":8,"radiance":[6e4,4e4,2e4]}"#;
    let cloud = format!(r#""clouds":[{{{CLOUD},"count":80,"opacity":[0.2,0.6]}}]"#);
    let ground = floor(r#"{"type":"ggx","base_color":[0.8,0.3,0.2],"roughness":0.3}"#).replace(
        "\"floor\",",
        "\"floor\",\"scale\":[1e-4,1,1e-4],\"rotate_deg\":[80,0,5],",
    );
    format!("{water},{sun},{cloud},{ground},{WHITE_SKY}")
}

// Any cut of the samples, and the machine without AVX2, give the same integers.
#[test]
fn sums_do_not_depend_on_cuts_or_instructions() {
    let eye = [0.0, 3.0, 12.0];
    let one = scene(
        &everything(),
        eye,
        [0.0; 3],
        50.0,
        12,
        BuildOptions::default(),
    );
    let portable = scene(
        &everything(),
        eye,
        [0.0; 3],
        50.0,
        12,
        BuildOptions {
            portable_simd: true,
        },
    );
    let whole = sums(&one, 0..24);
    assert_eq!(sums(&portable, 0..24), whole);
    let mut film = TileFilm::zero(RECT.pixels());
    for range in [13..24, 0..1, 4..13, 1..4] {
        film.add(&sums(&one, range)).expect("fits");
    }
    let mut expected = TileFilm::zero(RECT.pixels());
    expected.add(&whole).expect("fits");
    assert_eq!(film, expected);
    assert!(whole.radiance[0].iter().any(|&v| v > 0) && whole.radiance[0] != whole.radiance[1]);
}

#[test]
fn another_seed_is_another_picture() {
    let eye = [0.0, 3.0, 12.0];
    let one = scene(
        &everything(),
        eye,
        [0.0; 3],
        50.0,
        12,
        BuildOptions::default(),
    );
    let two = scene(
        &everything(),
        eye,
        [0.0; 3],
        50.0,
        13,
        BuildOptions::default(),
    );
    assert_ne!(sums(&one, 0..2).radiance, sums(&two, 0..2).radiance);
}

#[test]
fn a_cancelled_run_gives_nothing() {
    let scene = scene(
        WHITE_SKY,
        [0.0, 3.0, 12.0],
        [0.0; 3],
        50.0,
        12,
        BuildOptions::default(),
    );
    assert!(render_run(&scene, &RECT, 0..8, &AtomicBool::new(true)).is_none());
}
