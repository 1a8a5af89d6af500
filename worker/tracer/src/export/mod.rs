//! One frame of a scene as the files that other renderers read: to make the same
//! picture with them, and to compare.

mod ply;
mod sky;

use crate::load::{Assets, LoadedMesh, load_mesh, resolve_materials};
use crate::scene::motion::view;
use crate::scene::{BuildOptions, Scene, Stage};
use glam::{Affine3A, DVec3, Vec3};
use ply::{Faces, ply};
use shearwater_shared::job::RenderSettings;
use shearwater_shared::scene::{Cloud, Material, SceneDescription, SceneError, Sky};
use shearwater_shared::stop::Stop;
use std::collections::BTreeMap;

/// A frame, apart from the water's waves ([`crate::water::water_pictures`]) and
/// what the description says itself. Scene coordinates, metres.
#[derive(Clone, Debug)]
pub struct Export {
    /// Where the camera is when the shutter opens.
    pub eye_m: [f64; 3],
    /// Where it looks.
    pub target_m: [f64; 3],
    /// One for each instance and each of its materials that some triangle has.
    pub meshes: Vec<ExportedMesh>,
    /// Cloud particles that are not wholly under water.
    pub particles: Vec<ExportedParticle>,
    /// The sky without its sun.
    pub sky: Option<ExportedSky>,
    /// The sun.
    pub sun: Option<ExportedSun>,
}

/// Triangles of one material of one instance.
#[derive(Clone, Debug)]
pub struct ExportedMesh {
    /// Number of the instance in the scene.
    pub instance: usize,
    /// How it scatters; textures by the names that the scene uses.
    pub material: Material,
    /// Its triangles.
    pub triangles: usize,
    /// Binary PLY: positions, unit shading normals, `u` and `v` (upwards, zero where
    /// the mesh has none), in scene coordinates when the shutter opens.
    pub ply: Vec<u8>,
}

/// An ellipsoid with axes along the scene's.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ExportedParticle {
    /// Centre, metres.
    pub centre_m: [f64; 3],
    /// Half axes, metres.
    pub radii_m: [f32; 3],
    /// Chance that one crossing of its wall stops a ray.
    pub opacity: f32,
    /// Share of light that its wall scatters, as an ideal diffuse surface.
    pub albedo: [f32; 3],
}

/// The sky as a picture.
#[derive(Clone, Debug)]
pub struct ExportedSky {
    /// EXR of radiance, equirectangular: the middle column looks along -z, columns
    /// grow towards +x, the top row looks along +y.
    pub exr: Vec<u8>,
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
}

/// The sun as a disc at infinity.
#[derive(Clone, Copy, Debug)]
pub struct ExportedSun {
    /// Unit direction towards its centre.
    pub direction: [f32; 3],
    /// Angular radius in degrees.
    pub angular_radius_deg: f64,
    /// Radiance of the disc.
    pub radiance: [f32; 3],
}

/// Frame `frame` of a scene as its shutter opens; motion blur is not exported.
///
/// # Errors
/// What [`Stage::build`] and [`Stage::frame`] find; clouds of sprites or volumes and
/// skies on a dome, which have no counterpart elsewhere.
pub fn export(
    description: &SceneDescription,
    assets: &Assets,
    frame: u32,
) -> Result<Export, SceneError> {
    refuse(description)?;
    let (stage, _) = Stage::build(description, assets, BuildOptions::default())?;
    let settings = RenderSettings {
        width: description.image.width,
        height: description.image.height,
        samples: description.job.samples,
        seed: 0,
        frames: 1,
        first_frame: frame,
        stop: Stop::NONE,
    };
    let scene = stage.frame(&settings, frame)?;
    let anchor_m = stage.anchor_m();
    let (eye, target) = view(&description.camera, description.frame_time_s(frame));
    Ok(Export {
        eye_m: eye.to_array(),
        target_m: target.to_array(),
        meshes: meshes(description, assets, &scene, anchor_m)?,
        particles: particles(&scene, anchor_m),
        sky: scene.common.sky.as_ref().map(sky::picture).transpose()?,
        sun: sun(description, &scene),
    })
}

/// What other renderers have nothing like.
fn refuse(description: &SceneDescription) -> Result<(), SceneError> {
    let refused = |path: String, message| Err(SceneError::new("scene.json", path, message));
    if let Some(Sky::Dome(_)) = &description.sky {
        let message = "a dome cannot be exported: take a map, which is infinitely far";
        return refused("sky".to_owned(), message);
    }
    for (number, cloud) in description.clouds.iter().enumerate() {
        if !matches!(cloud, Cloud::Particles(_)) {
            let message = "only clouds of particles can be exported";
            return refused(format!("clouds[{number}]"), message);
        }
    }
    Ok(())
}

fn meshes(
    description: &SceneDescription,
    assets: &Assets,
    scene: &Scene,
    anchor_m: DVec3,
) -> Result<Vec<ExportedMesh>, SceneError> {
    let mut loaded = BTreeMap::new();
    for (name, mesh) in &description.meshes {
        let (shape, _) = load_mesh(&mesh.file, mesh, assets)?;
        let materials =
            resolve_materials(&mesh.file, mesh, &shape, &description.materials, assets)?;
        loaded.insert(name.as_str(), (shape, materials));
    }
    let mut all = Vec::new();
    let placed = description.instances.iter().zip(scene.geometry.instances());
    for (number, (instance, placed)) in placed.enumerate() {
        let Some((shape, materials)) = loaded.get(instance.mesh.as_str()) else {
            continue;
        };
        let replaced = instance.material.as_ref();
        let replaced = replaced.and_then(|name| description.materials.get(name));
        for (k, own) in materials.iter().enumerate() {
            let of_material = |&t: &usize| usize::from(shape.material_of[t]) == k;
            let faces: Vec<_> = (0..shape.triangles.len()).filter(of_material).collect();
            if faces.is_empty() {
                continue;
            }
            all.push(ExportedMesh {
                instance: number,
                material: replaced.unwrap_or(own).clone(),
                triangles: faces.len(),
                ply: world_ply(shape, &faces, placed.world_from_local(), anchor_m),
            });
        }
    }
    Ok(all)
}

/// Some triangles of a mesh where an instance stands.
fn world_ply(
    shape: &LoadedMesh,
    triangles: &[usize],
    render_from_local: &Affine3A,
    anchor_m: DVec3,
) -> Vec<u8> {
    let mut faces = Faces::default();
    let mut number_of = vec![u32::MAX; shape.positions.len()];
    let normal_from_local = glam::Mat3::from(render_from_local.matrix3)
        .inverse()
        .transpose();
    for &t in triangles {
        let corners = shape.triangles[t].map(|vertex| {
            let v = vertex as usize;
            if number_of[v] == u32::MAX {
                number_of[v] = faces.positions.len() as u32;
                let p = render_from_local.transform_point3(shape.positions[v]);
                faces.positions.push((p.as_dvec3() + anchor_m).as_vec3());
                let n = shape.normals.get(v).copied().unwrap_or(Vec3::ZERO);
                faces
                    .normals
                    .push((normal_from_local * n).normalize_or_zero());
                faces
                    .uvs
                    .push(shape.uvs.get(v).copied().unwrap_or_default());
            }
            number_of[v]
        });
        // A mirrored instance turns its triangles inside out.
        let mirrored = render_from_local.matrix3.determinant() < 0.0;
        let [a, b, c] = corners;
        faces
            .triangles
            .push(if mirrored { [a, c, b] } else { corners });
    }
    ply(&faces)
}

fn particles(scene: &Scene, anchor_m: DVec3) -> Vec<ExportedParticle> {
    let Some(particles) = scene.geometry.particles() else {
        return Vec::new();
    };
    let exported = |(number, e): (usize, &crate::geometry::Ellipsoid)| ExportedParticle {
        centre_m: (e.centre.as_dvec3() + anchor_m).to_array(),
        radii_m: e.radii.to_array(),
        opacity: e.opacity,
        albedo: scene.particle_bsdf(number as u32).albedo().to_array(),
    };
    particles
        .ellipsoids()
        .iter()
        .enumerate()
        .map(exported)
        .collect()
}

fn sun(description: &SceneDescription, scene: &Scene) -> Option<ExportedSun> {
    let (described, light) = (description.sun.as_ref()?, scene.common.sun.as_ref()?);
    Some(ExportedSun {
        direction: light.direction().to_array(),
        angular_radius_deg: described.angular_radius_deg,
        radiance: light.radiance.to_array(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn description(extra: &serde_json::Value) -> SceneDescription {
        let mut scene = json!({
            "version": 1, "name": "t", "image": {"width": 8, "height": 4},
            "camera": {"position_m": [1e4, 2, 0], "target_m": [1e4, 2, -9], "up": [0, 1, 0],
                       "vertical_fov_deg": 40},
            "materials": {"a": {"type": "lambert", "albedo": [0.5, 0.5, 0.5]}},
            "meshes": {"m": {"file": "m.obj", "materials": {"x": "a"}}},
            "instances": [{"mesh": "m", "translate_m": [1e4, 0, 0], "scale": [-2, 1, 1]}],
            "sky": {"type": "constant", "radiance": [1, 2, 3]}
        });
        for (key, value) in extra.as_object().expect("an object") {
            scene[key] = value.clone();
        }
        let bytes = serde_json::to_vec(&scene).expect("JSON");
        shearwater_shared::scene::parse(&bytes).expect("a scene")
    }

    fn assets() -> Assets {
        let obj = "usemtl x\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
        [("m.obj".to_owned(), obj.as_bytes().into())].into()
    }

    #[test]
    fn a_mesh_comes_where_its_instance_stands() {
        let exported = export(&description(&json!({})), &assets(), 0).expect("exported");
        let [mesh] = &exported.meshes[..] else {
            panic!("one mesh");
        };
        assert_eq!((mesh.instance, mesh.triangles), (0, 1));
        let body = ply::tests::body(&mesh.ply);
        // Twice as wide, mirrored, and the winding with it: the normal stays +z.
        let x: Vec<f32> = (0..3).map(|i| ply::tests::float(body, i * 8)).collect();
        assert_eq!(x, [1e4, 9998.0, 1e4]);
        assert_eq!(ply::tests::float(body, 5), 1.0);
        let faces = &body[3 * 32..];
        assert_eq!(faces[0], 3);
        assert_eq!((faces[1], faces[5], faces[9]), (0, 2, 1));
        let sky = exported.sky.expect("a sky");
        assert_eq!((sky.width, sky.height), sky::CONSTANT_SIZE);
        assert!(exported.sun.is_none() && exported.particles.is_empty());
    }

    #[test]
    fn particles_come_where_they_are() {
        let cloud = json!({"clouds": [{
            "type": "particles",
            "formation": {"type": "radial", "centre_m": [1e4, 50, -100], "radii_m": [3, 3, 3],
                          "direction": [0, 1, 0], "length_m": 0},
            "count": 20, "particle_radius_m": [1, 2], "stretch_x": [2, 2], "opacity": [0.5, 0.5],
            "albedo": [0.9, 0.8, 0.7], "seed": 1
        }]});
        let exported = export(&description(&cloud), &assets(), 0).expect("exported");
        assert_eq!(exported.particles.len(), 20);
        for p in &exported.particles {
            let centre = DVec3::from_array(p.centre_m) - DVec3::new(1e4, 50.0, -100.0);
            assert!(centre.length() < 4.0, "{centre}");
            assert_eq!(p.radii_m[0], 2.0 * p.radii_m[1]);
            assert_eq!((p.opacity, p.albedo), (0.5, [0.9, 0.8, 0.7]));
        }
    }

    #[test]
    fn what_has_no_counterpart_is_refused() {
        let formation = json!({"type": "radial", "centre_m": [0, 0, 0], "radii_m": [1, 1, 1],
                               "direction": [0, 1, 0], "length_m": 0});
        let sprites = json!({"clouds": [{"type": "sprites", "formation": formation, "count": 2,
                                         "sprite_radius_m": [1, 2], "opacity": [0.5, 0.5]}]});
        let dome = json!({"sky": {"type": "dome", "file": "s.exr", "centre_m": [0, 0, 0],
                                  "radius_m": 1e5}});
        for (extra, place) in [(sprites, "clouds[0]"), (dome, "sky")] {
            let error = export(&description(&extra), &assets(), 0).expect_err("refused");
            assert!(error.to_string().contains(place), "{error}");
        }
    }
}
