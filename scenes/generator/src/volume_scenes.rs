//! The scenes of `scenes/clouds` whose clouds are volumes: by both methods, and from a
//! grid of densities.

use crate::assets::Asset;
use crate::{composition, puffs};

/// Two wisps with a plane in each, two cumuli behind the bridge.
const ELLIPSOIDS: [&str; 4] = [
    r#""shape": {"type": "ellipsoid", "centre_m": [-10, 12, -56], "radii_m": [20, 6, 11], "edge": 0.7, "resolution": 192, "noise": {"scale_m": 7, "amplitude": 0.95, "coverage": 0.5, "octaves": 6, "seed": 3}}, "sigma_t_per_m": 0.5"#,
    r#""shape": {"type": "ellipsoid", "centre_m": [13, 11.5, -24], "radii_m": [7, 2.4, 4], "edge": 0.7, "resolution": 128, "noise": {"scale_m": 2.6, "amplitude": 0.95, "coverage": 0.5, "octaves": 6, "seed": 4}}, "sigma_t_per_m": 0.9"#,
    r#""shape": {"type": "ellipsoid", "centre_m": [-330, 95, -860], "radii_m": [170, 62, 80], "edge": 0.6, "resolution": 192, "noise": {"scale_m": 62, "amplitude": 0.9, "coverage": 0.55, "octaves": 6, "seed": 8}}, "sigma_t_per_m": 0.15"#,
    r#""shape": {"type": "ellipsoid", "centre_m": [430, 140, -1000], "radii_m": [150, 75, 80], "edge": 0.6, "resolution": 192, "noise": {"scale_m": 62, "amplitude": 0.9, "coverage": 0.55, "octaves": 6, "seed": 9}}, "sigma_t_per_m": 0.15"#,
];
/// Steps of the marched ones: about four mean free paths, so that the bias shows.
const STEPS_M: [f64; 4] = [4.0, 1.5, 40.0, 40.0];
/// The same file three times.
const GRIDS: [&str; 3] = [
    r#""shape": {"type": "grid", "file": "assets/cumulus.vol", "centre_m": [-300, 105, -860], "size_m": [352, 160, 224], "rotate_y_deg": 20}, "sigma_t_per_m": 0.12"#,
    r#""shape": {"type": "grid", "file": "assets/cumulus.vol", "centre_m": [400, 130, -1000], "size_m": [396, 180, 252], "rotate_y_deg": 200}, "sigma_t_per_m": 0.12"#,
    r#""shape": {"type": "grid", "file": "assets/cumulus.vol", "centre_m": [-11, 12.5, -56], "size_m": [37.4, 17, 23.8], "rotate_y_deg": -30}, "sigma_t_per_m": 0.35"#,
];

/// The files of the volume scenes.
pub(crate) fn volumes() -> Vec<Asset> {
    let cloud = |shape: &str, method: &str| {
        format!(
            r#"{{"type": "volume", {shape}, "albedo": [0.999, 0.999, 0.999], "g": 0.5{method}}}"#
        )
    };
    let tracked: Vec<String> = ELLIPSOIDS.iter().map(|shape| cloud(shape, "")).collect();
    let marched: Vec<String> = ELLIPSOIDS
        .iter()
        .zip(STEPS_M)
        .map(|(shape, step_m)| {
            let method = format!(r#", "method": {{"type": "march", "step_m": {step_m}}}"#);
            cloud(shape, &method)
        })
        .collect();
    let grids: Vec<String> = GRIDS.iter().map(|shape| cloud(shape, "")).collect();
    let scene = |path, name, clouds: &[String]| Asset {
        path,
        bytes: composition::with_clouds(name, clouds).into_bytes(),
    };
    vec![
        scene("volume.json", "volume", &tracked),
        scene("volume-march.json", "volume-march", &marched),
        scene("volume-grid.json", "volume-grid", &grids),
        Asset {
            path: "assets/cumulus.vol",
            bytes: puffs::vol(),
        },
    ]
}
