//! Water with waves as bumps, under light of radiance 1 from everywhere.

use crate::common::{WHITE_SKY, mean_and_error, scene};
use crate::support::gallery::{plain_tables, water};
use crate::support::{direction, uniform3};
use crate::table::{Case, Form, Law, Row, Section};
use glam::Vec3;
use shearwater_tracer::BuildOptions;
use shearwater_tracer::bsdf::leaning::Leaning;
use shearwater_tracer::bsdf::shading_frame::{bend_normal, face_viewer};
use shearwater_tracer::bsdf::{Bsdf, Tables};
use shearwater_tracer::math::frame::Frame;

static SECTION: Section = Section::new(
    "Bump-mapped water in a furnace",
    &[
        Case {
            name: "the sea, white body",
            note: "Whole paths over Tessendorf's waves, views of 20, 5 and 1 degrees of elevation. Directions below the water's \
                   plane are folded up (as by a mirror in that plane), the normal is bent where the viewer or the mirror image \
                   lies below: everything that the interface and a white body reflect leaves the water. Dropped, as for \
                   other materials, those directions would cost up to 2.7 %. The tolerance holds 0.2 % for the albedo table, \
                   which may darken and not brighten (below).",
            broken_by: "directions below the plane dropped (0.973 at 1 degree and roughness 0.5)",
            rows: sea,
        },
        Case {
            name: "one reflection on a leaning normal",
            note: "The integral over the directions above the plane of what leaning normals reflect, for the normals of \
                   slopes up to 0.5 in all directions: the most and the least.",
            broken_by: "the folded part left out of value and density",
            rows: leaning_normals,
        },
        Case {
            name: "views from under the shading normal",
            note: "Of leaning normals that face away from the viewer: how many, bent, still face away, and how many samples \
                   find no light (black pixels), the mirror and the rough surface.",
            broken_by: "the normal not bent",
            rows: from_under,
        },
        Case {
            name: "a wide sun on the sea",
            note: "Light samples, chance hits and both weighed against each other must agree where directions are folded: the \
                   difference to chance hits alone.",
            broken_by: "the folded part left out of value and density",
            rows: wide_sun,
        },
    ],
);

#[test]
fn water_furnace() {
    SECTION.check();
}

const ELEVATIONS_DEG: [f64; 3] = [20.0, 5.0, 1.0];

/// A sea seen at so many degrees above the horizon; `light` is JSON.
fn sea_at(
    degrees: f64,
    wind: f64,
    roughness: f64,
    light: &str,
    seed: u64,
) -> shearwater_tracer::Scene {
    let water = format!(
        r#""water":{{"type":"tessendorf","tile_m":100,"wind_speed_mps":{wind},"cutoff_m":0.5,
        "body_color":[1,1,1],"roughness":{roughness}}}"#
    );
    let height = 2.0;
    let eye = [0.0, height, height / libm::tan(degrees.to_radians())];
    scene(
        &format!("{water},{light}"),
        eye,
        [0.0; 3],
        0.5,
        seed,
        BuildOptions::default(),
    )
}

fn sea(form: Form) -> Vec<Row> {
    let mut rows = Vec::new();
    for (wind, roughness) in [(8.0, 0.0), (8.0, 0.1), (15.0, 0.0), (15.0, 0.5)] {
        for degrees in ELEVATIONS_DEG {
            let scene = sea_at(degrees, wind, roughness, WHITE_SKY, 11);
            let (mean, error) = mean_and_error(&scene, form.pick(64, 4096));
            let at = format!("wind {wind} m/s, roughness {roughness}, {degrees} deg");
            rows.push(Row::sampled(at, 1.0, mean, 4.0, error, 2e-3));
        }
    }
    rows
}

/// The view along `wo` of a plane of normal z whose shading normal has this slope.
fn view(slope: [f64; 2], wo: Vec3) -> Leaning {
    let normal = Vec3::new(-slope[0] as f32, -slope[1] as f32, 1.0).normalize();
    let (shading, geometric) = face_viewer(normal, Vec3::Z, wo);
    let frame = Frame::from_normal(bend_normal(shading, geometric, wo));
    Leaning {
        frame,
        geometric,
        wo_local: frame.to_local(wo),
        water: true,
    }
}

/// The integral over the directions above the plane; midpoints, even in height
/// and azimuth.
fn reflected(view: &Leaning, bsdf: &Bsdf, tables: &Tables, points: u32) -> f64 {
    let [rows, columns] = [points, 2 * points];
    let mut sum = 0.0;
    for y in 0..rows {
        // Finer near the horizon, where rough water throws much of its light.
        let t = (f64::from(y) + 0.5) / f64::from(rows);
        let z = t * t;
        let r = libm::sqrt(1.0 - z * z);
        for x in 0..columns {
            let turn = core::f64::consts::TAU * (f64::from(x) + 0.5) / f64::from(columns);
            let wi = Vec3::new(
                (r * libm::cos(turn)) as f32,
                (r * libm::sin(turn)) as f32,
                z as f32,
            );
            sum += 2.0 * t * f64::from(view.eval_pdf(bsdf, tables, wi).0.x);
        }
    }
    sum * core::f64::consts::TAU / f64::from(rows * columns)
}

fn leaning_normals(form: Form) -> Vec<Row> {
    let tables = plain_tables();
    let mut rows = Vec::new();
    for alpha in [0.25, 0.4, 0.8] {
        let bsdf = water(&tables, Vec3::ONE, alpha);
        for degrees in ELEVATIONS_DEG {
            let wo = direction(90.0 - degrees, 0.0);
            let (mut most, mut least) = (0.0f64, 2.0f64);
            for slope in [0.0, 0.1, 0.25, 0.5] {
                for turn in 0..form.pick(3, 8) {
                    let around =
                        core::f64::consts::TAU * f64::from(turn) / f64::from(form.pick(3, 8));
                    let slope = [slope * libm::cos(around), slope * libm::sin(around)];
                    let e = reflected(&view(slope, wo), &bsdf, &tables, form.pick(200, 500));
                    most = most.max(e);
                    least = least.min(e);
                }
            }
            rows.push(Row::at_most(
                format!("alpha {alpha}, {degrees} deg, most"),
                1.0 + 1e-4,
                most,
            ));
            rows.push(Row::at_least(
                format!("alpha {alpha}, {degrees} deg, least"),
                0.998,
                least,
            ));
        }
    }
    rows
}

fn from_under(form: Form) -> Vec<Row> {
    let tables = plain_tables();
    let mut rows = Vec::new();
    for alpha in [0.0, 0.2] {
        let bsdf = water(&tables, Vec3::ONE, alpha);
        for degrees in ELEVATIONS_DEG {
            let wo = direction(90.0 - degrees, 0.0);
            let (mut still, mut black, mut seen) = (0u32, 0u32, 0u32);
            for i in 0..form.pick(40_000, 1_000_000) {
                let [a, b, _] = uniform3(8, i);
                // Leaning away from the viewer, who looks along -x.
                let slope = [f64::from(a), f64::from(b) - 0.5];
                let facing =
                    f64::from(wo.z) - slope[0] * f64::from(wo.x) - slope[1] * f64::from(wo.y);
                if facing >= 0.0 {
                    continue;
                }
                seen += 1;
                let view = view(slope, wo);
                still += u32::from(view.wo_local.z < 0.0);
                black += u32::from(view.sample(&bsdf, &tables, uniform3(9, i)).is_none());
            }
            let at = |what| format!("alpha {alpha}, {degrees} deg, {what}");
            rows.push(Row::at_least(at("looked at"), 10_000.0, f64::from(seen)));
            rows.push(Row::exact(at("still under"), 0.0, f64::from(still)));
            // A rough surface throws some normals' light under its own horizon.
            let most = if alpha == 0.0 { 0.0 } else { 0.01 };
            rows.push(Row::at_most(
                at("share of black samples"),
                most,
                f64::from(black) / f64::from(seen),
            ));
        }
    }
    rows
}

fn wide_sun(form: Form) -> Vec<Row> {
    let mut rows = Vec::new();
    for degrees in [20.0, 1.0] {
        let light = |mis: &str| {
            format!(
                r#""sun":{{"azimuth_deg":0,"elevation_deg":5,"angular_radius_deg":40,"radiance":[1,1,1]}},
                "sampling":{{"mis":"{mis}"}}"#
            )
        };
        let samples = form.pick(192, 8192);
        let by = |mis: &str, seed| {
            mean_and_error(&sea_at(degrees, 10.0, 0.5, &light(mis), seed), samples)
        };
        let (chance, error) = by("scattering_only", 21);
        for (mis, seed) in [("power", 22), ("balance", 23), ("lights_only", 24)] {
            let (mean, other) = by(mis, seed);
            let sigma = libm::sqrt(error * error + other * other);
            let at = format!("{mis}, {degrees} deg, in standard errors");
            rows.push(Row::at_most(at, 4.0, (mean - chance).abs() / sigma).by(Law::Sigma(4.0)));
            rows.push(Row::at_least(
                format!("{mis}, {degrees} deg, light over its standard error"),
                100.0,
                mean / sigma,
            ));
        }
    }
    rows
}
