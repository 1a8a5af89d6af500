//! Textures that drive roughness and metalness, and metals under a white sky.

use crate::common::{FLOOR, SIDE, WHITE_SKY, assert_mean, floor, mean_and_error, scene};
use shearwater_shared::job::RenderSettings;
use shearwater_shared::scene::parse;
use shearwater_tracer::{Assets, BuildOptions, Scene};
use std::sync::Arc;

/// Three texels: 0, 128 and 255.
const LEVELS: [u8; 3] = [0, 128, 255];

/// Levels in one channel, their complement in the others.
fn levels(channel: usize) -> Vec<u8> {
    let rgb = LEVELS.map(|level| {
        let mut texel = [255 - level; 3];
        texel[channel] = level;
        texel
    });
    let image = image::RgbImage::from_raw(3, 1, rgb.concat()).expect("three texels");
    let mut bytes = std::io::Cursor::new(Vec::new());
    image
        .write_to(&mut bytes, image::ImageFormat::Png)
        .expect("a PNG");
    bytes.into_inner()
}

/// A floor of one texel, seen from straight above under a white sky.
fn textured(material: &str, texel: usize) -> Scene {
    let json = format!(
        r#"{{"version":1,"name":"test","image":{{"width":{SIDE},"height":{SIDE}}},
        "camera":{{"position_m":[0,3,0],"target_m":[0,0,0],"up":[0,0,-1],"vertical_fov_deg":2,"shutter_s":0}},
        "meshes":{{"floor":{{"file":"floor.obj"}}}},"materials":{{"m":{material}}},
        "instances":[{{"mesh":"floor","material":"m"}}],{WHITE_SKY}}}"#
    );
    let u = (texel as f64 + 0.5) / 3.0;
    let corners = FLOOR.replace("f 1 2 3 4", "f 1/1 2/1 3/1 4/1");
    let files = [
        ("floor.obj", format!("vt {u} 0.5\n{corners}").into_bytes()),
        ("r.png", levels(0)),
        ("g.png", levels(1)),
        ("b.png", levels(2)),
    ];
    let assets: Assets = files
        .map(|(name, bytes)| (name.to_owned(), Arc::from(bytes)))
        .into();
    let settings = RenderSettings {
        width: SIDE,
        height: SIDE,
        samples: 2,
        seed: 7,
        frames: 1,
        first_frame: 0,
        stop: shearwater_shared::stop::Stop::NONE,
    };
    let description = parse(json.as_bytes()).expect("a valid scene");
    Scene::build(&description, &assets, &settings, 0, BuildOptions::default())
        .expect("a scene that builds")
        .0
}

// A white metal that reflects once reflects E(alpha) at normal incidence; a linear
// texel of 128/255 and a factor of 0.8 make a roughness of 0.4016. Read as sRGB it
// would be 0.173, and E nearly 1.
#[test]
fn a_texture_drives_roughness() {
    for (texel, alpha) in [
        (0, 0.0),
        (1, 0.64 * (128.0 / 255.0) * (128.0 / 255.0)),
        (2, 0.64),
    ] {
        let expected = single_scattering(alpha);
        for (channel, file) in [("r", "r.png"), ("g", "g.png"), ("b", "b.png")] {
            let material = format!(
                r#"{{"type":"ggx","metalness":1,"roughness":0.8,"roughness_texture":{{"file":"{file}","channel":"{channel}"}}}}"#
            );
            let what = format!("roughness texel {texel} of {file}");
            assert_mean(&what, &textured(&material, texel), 256, expected);
        }
    }
}

// E at normal incidence, by the sum over visible normals: at wo = n the half
// vector has density D cos, tan^2 = alpha^2 u/(1 - u), and E = mean of G1(wi).
fn single_scattering(alpha: f64) -> f64 {
    let points = 200_000;
    let sum: f64 = (0..points)
        .map(|i| {
            let u = (f64::from(i) + 0.5) / f64::from(points);
            let tan2 = alpha * alpha * u / (1.0 - u);
            let cos = (1.0 - tan2) / (1.0 + tan2);
            if cos <= 0.0 {
                return 0.0;
            }
            // G2/G1 at wo = n is G1 of wi.
            2.0 * cos / (cos + (cos * cos + alpha * alpha * (1.0 - cos * cos)).sqrt())
        })
        .sum();
    sum / f64::from(points)
}

// Smooth, base colour 0.2, F0 of the dielectric 0.5: F0 and body follow the mixture.
#[test]
fn a_texture_drives_metalness() {
    for (texel, metalness) in [(0, 0.0), (1, 128.0 / 255.0), (2, 1.0)] {
        let f0 = 0.5 + (0.2 - 0.5) * metalness;
        let expected = f0 + 0.2 * (1.0 - metalness) * (1.0 - f0);
        let material = r#"{"type":"ggx","base_color":[0.2,0.2,0.2],"specular_f0":0.5,"roughness":0,
            "metalness_texture":{"file":"b.png","channel":"b"}}"#;
        let (mean, error) = mean_and_error(&textured(material, texel), 512);
        // 1e-3 for the table of albedos.
        assert!(
            (mean - expected).abs() < 5.0 * error + 1e-3 && error < 2e-3,
            "texel {texel}: {mean} +- {error}, {expected}"
        );
    }
}

// The same file as colour and as data is two things.
#[test]
fn colours_are_decoded_and_data_are_not() {
    let color = r#"{"type":"lambert","albedo":[1,1,1],"albedo_texture":"r.png"}"#;
    let expected = libm::pow((128.0 / 255.0 + 0.055) / 1.055, 2.4);
    assert_mean("sRGB", &textured(color, 1), 64, expected);
    let both = r#"{"type":"ggx","roughness":0,"metalness":1,"base_color_texture":"r.png",
        "metalness_texture":{"file":"r.png"},"specular_f0":0}"#;
    let metalness = 128.0 / 255.0;
    let f0 = expected * metalness;
    let body = expected * (1.0 - metalness) * (1.0 - f0);
    let (mean, error) = mean_and_error(&textured(both, 1), 512);
    assert!(
        (mean - f0 - body).abs() < 5.0 * error + 1e-3,
        "{mean} +- {error}, {}",
        f0 + body
    );
}

// Straight down on polished silver-like metals, bare and varnished.
#[test]
fn metals_reflect_by_their_index() {
    let (n, k) = (0.2_f64, 3.5_f64);
    let metal = ((n - 1.0) * (n - 1.0) + k * k) / ((n + 1.0) * (n + 1.0) + k * k);
    let coat: f64 = 0.04;
    for (coated, expected) in [
        ("", metal),
        (
            r#","coat":{"ior":1.5}"#,
            coat + (1.0 - coat) * (1.0 - coat) * metal,
        ),
    ] {
        let material = format!(
            r#"{{"type":"ggx","roughness":0,"conductor":{{"n":[{n},1,1],"k":[{k},1,1]}}{coated}}}"#
        );
        let body = format!("{},{WHITE_SKY}", floor(&material));
        let scene = scene(
            &body,
            [0.0, 3.0, 0.0],
            [0.0; 3],
            1.0,
            5,
            BuildOptions::default(),
        );
        assert_mean(&material, &scene, 256, expected);
    }
}

// One lobe's own density or that of both: the same light, from sun and sky.
#[test]
fn lobe_sampling_agrees_with_the_mixture() {
    let lights = format!(
        r#"{WHITE_SKY},"sun":{{"azimuth_deg":20,"elevation_deg":50,"angular_radius_deg":10,"radiance":[20,20,20]}}"#
    );
    for material in [
        r#""type":"phong","kd":[0.5,0.5,0.5],"ks":[0.5,0.5,0.5],"exponent":50"#,
        r#""type":"ggx","model":"report","roughness":0.5,"base_color":[0.6,0.6,0.6]"#,
    ] {
        let means = ["mixture", "lobe"].map(|sampling| {
            let body = format!(
                r#"{},{lights}"#,
                floor(&format!(r#"{{{material},"sampling":"{sampling}"}}"#))
            );
            let scene = scene(
                &body,
                [0.0, 2.0, 2.0],
                [0.0; 3],
                20.0,
                8,
                BuildOptions::default(),
            );
            mean_and_error(&scene, 512)
        });
        let [(a, ea), (b, eb)] = means;
        let error = (ea * ea + eb * eb).sqrt();
        assert!(
            (a - b).abs() < 5.0 * error && error < 0.02 * a,
            "{material}: {means:?}"
        );
    }
}
