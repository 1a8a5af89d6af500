//! The blur of water.

use crate::common::{CLOUD, SIDE, WHITE_SKY, sums};
use shearwater_shared::job::RenderSettings;
use shearwater_shared::scene::parse;
use shearwater_tracer::{Assets, BuildOptions, Scene};

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
            first_frame: 0,
            stop: shearwater_shared::stop::Stop::NONE,
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
