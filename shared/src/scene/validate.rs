//! Ranges and references of a scene.

use super::at::At;
use super::range::{
    COORDINATE, LENGTH, RADIANCE, Range, SHARE, SIZE, TURN, asset, bounds, count, defined,
    direction, length_squared, number, numbers, shares,
};
use super::{
    Camera, Cloud, Image, Instance, Material, Mesh, Post, SceneDescription, SceneError, Sky, Sun,
    Water,
};
use crate::limits;

/// Longest shutter in seconds: an hour.
const SHUTTER_S_MAX: f64 = 3600.0;
/// Sine of the smallest angle between `up` and the view: below it the picture's
/// horizontal is noise of the last digits.
const UP_SINE_MIN: f64 = 1e-6;
/// Fastest wind in metres per second: twice the worst storm. Calm is a light
/// breeze; the spectrum has no waves at 0.
const WIND_MPS: Range = Range::Closed(0.1, 200.0);
/// Side of the water tile in metres: from a puddle to where one period spans
/// the sea that a camera sees.
const TILE_M: Range = Range::Closed(0.01, 1e6);
/// Any velocity in metres per second: beyond the fastest spacecraft.
const VELOCITY_MPS: Range = Range::Closed(-1e5, 1e5);

/// Check every range and every name.
pub(super) fn validate(scene: &SceneDescription) -> Result<(), SceneError> {
    let root = At::root();
    name(&root.field("name"), &scene.name)?;
    image(&root.field("image"), scene.image)?;
    samples(&root.field("job"), scene.job.samples)?;
    camera(&root.field("camera"), &scene.camera)?;
    materials(&root.field("materials"), scene)?;
    meshes(&root.field("meshes"), scene)?;
    instances(&root.field("instances"), scene)?;
    if let Some(sky_described) = &scene.sky {
        sky(&root.field("sky"), sky_described)?;
    }
    if let Some(sun_described) = &scene.sun {
        sun(&root.field("sun"), sun_described)?;
    }
    if let Some(water_described) = &scene.water {
        water(&root.field("water"), water_described)?;
    }
    clouds(&root.field("clouds"), &scene.clouds)?;
    post(&root.field("post"), &scene.post)
}

/// The scene's name becomes the name of files.
fn name(at: &At<'_>, name: &str) -> Result<(), SceneError> {
    count(at, name.len() as u64, 1, limits::NAME_BYTES_MAX as u64)
        .map_err(|e| at.error(format!("{} bytes", e.message)))?;
    if name.contains(['/', '\\']) || name.starts_with('.') || name.chars().any(char::is_control) {
        return Err(at.error(format!(
            "{name:?}: expected a name for files, without `/`, `\\`, control characters or a \
             leading `.`"
        )));
    }
    Ok(())
}

fn image(at: &At<'_>, image: Image) -> Result<(), SceneError> {
    let side = u64::from(limits::IMAGE_SIDE_MAX);
    count(&at.field("width"), image.width.into(), 1, side)?;
    count(&at.field("height"), image.height.into(), 1, side)?;
    let pixels = u64::from(image.width) * u64::from(image.height);
    if pixels > limits::IMAGE_PIXELS_MAX {
        return Err(at.error(format!(
            "{pixels} pixels: expected at most {}",
            limits::IMAGE_PIXELS_MAX
        )));
    }
    Ok(())
}

fn samples(at: &At<'_>, samples: u32) -> Result<(), SceneError> {
    let at = at.field("samples");
    count(&at, samples.into(), 2, limits::SAMPLES_MAX.into())?;
    if samples.is_multiple_of(2) {
        Ok(())
    } else {
        Err(at.error(format!(
            "{samples}: expected an even number, because samples come in two halves"
        )))
    }
}

fn camera(at: &At<'_>, camera: &Camera) -> Result<(), SceneError> {
    numbers(&at.field("position_m"), &camera.position_m, COORDINATE, "m")?;
    numbers(&at.field("target_m"), &camera.target_m, COORDINATE, "m")?;
    direction(&at.field("up"), &camera.up)?;
    let fov = Range::Between(0.0, 179.0);
    let fov_at = at.field("vertical_fov_deg");
    number(&fov_at, camera.vertical_fov_deg, fov, "degrees")?;
    let shutter = Range::Closed(0.0, SHUTTER_S_MAX);
    number(&at.field("shutter_s"), camera.shutter_s, shutter, "s")?;
    number(
        &at.field("lens_radius_m"),
        camera.lens_radius_m,
        LENGTH,
        "m",
    )?;
    if let Some(distance) = camera.focus_distance_m {
        number(&at.field("focus_distance_m"), distance, SIZE, "m")?;
    }
    let [px, py, pz] = camera.position_m;
    let [tx, ty, tz] = camera.target_m;
    let view = [tx - px, ty - py, tz - pz];
    if length_squared(view) == 0.0 {
        return Err(at.field("target_m").error(format!(
            "{:?}: expected another point than position_m",
            camera.target_m
        )));
    }
    let side = cross(view, camera.up);
    let least = UP_SINE_MIN * UP_SINE_MIN * length_squared(view) * length_squared(camera.up);
    if length_squared(side) <= least {
        return Err(at.field("up").error(format!(
            "{:?}: expected a direction that is not along the view",
            camera.up
        )));
    }
    Ok(())
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

fn materials(at: &At<'_>, scene: &SceneDescription) -> Result<(), SceneError> {
    let most = limits::MATERIALS_MAX as u64;
    count(at, scene.materials.len() as u64, 0, most)?;
    for (key, described) in &scene.materials {
        material(&at.field(key), described)?;
    }
    Ok(())
}

fn material(at: &At<'_>, described: &Material) -> Result<(), SceneError> {
    let texture = |field: &str, name: &Option<String>| {
        name.as_ref()
            .map_or(Ok(()), |name| asset(&at.field(field), name))
    };
    match described {
        Material::Lambert(m) => {
            numbers(&at.field("albedo"), &m.albedo, SHARE, "")?;
            texture("albedo_texture", &m.albedo_texture)
        }
        Material::Phong(m) => {
            numbers(&at.field("kd"), &m.kd, SHARE, "")?;
            numbers(&at.field("ks"), &m.ks, SHARE, "")?;
            shares(at, &m.kd, &m.ks)?;
            let exponents = Range::Closed(0.0, 1e7);
            number(&at.field("exponent"), m.exponent, exponents, "")?;
            texture("kd_texture", &m.kd_texture)
        }
        Material::Ggx(m) => {
            numbers(&at.field("base_color"), &m.base_color, SHARE, "")?;
            number(&at.field("roughness"), m.roughness, SHARE, "")?;
            number(&at.field("metalness"), m.metalness, SHARE, "")?;
            number(&at.field("specular_f0"), m.specular_f0, SHARE, "")?;
            texture("base_color_texture", &m.base_color_texture)
        }
    }
}

fn meshes(at: &At<'_>, scene: &SceneDescription) -> Result<(), SceneError> {
    let most = limits::ASSETS_MAX as u64;
    count(at, scene.meshes.len() as u64, 0, most)?;
    for (key, described) in &scene.meshes {
        mesh(&at.field(key), described, scene)?;
    }
    Ok(())
}

fn mesh(at: &At<'_>, mesh: &Mesh, scene: &SceneDescription) -> Result<(), SceneError> {
    asset(&at.field("file"), &mesh.file)?;
    let crease_at = at.field("crease_angle_deg");
    let crease = Range::Closed(0.0, 180.0);
    number(&crease_at, mesh.crease_angle_deg, crease, "degrees")?;
    let map_at = at.field("materials");
    for (from, to) in &mesh.materials {
        let known = scene.materials.keys();
        defined(&map_at.field(from), "material", to, known)?;
    }
    Ok(())
}

fn instances(at: &At<'_>, scene: &SceneDescription) -> Result<(), SceneError> {
    let most = limits::INSTANCES_MAX as u64;
    count(at, scene.instances.len() as u64, 0, most)?;
    for (i, described) in scene.instances.iter().enumerate() {
        instance(&at.index(i), described, scene)?;
    }
    Ok(())
}

fn instance(at: &At<'_>, instance: &Instance, scene: &SceneDescription) -> Result<(), SceneError> {
    if !scene.meshes.contains_key(&instance.mesh) {
        defined(
            &at.field("mesh"),
            "mesh",
            &instance.mesh,
            scene.meshes.keys(),
        )?;
    }
    if let Some(name) = &instance.material
        && !scene.materials.contains_key(name)
    {
        let known = scene.materials.keys();
        defined(&at.field("material"), "material", name, known)?;
    }
    let moved = at.field("translate_m");
    numbers(&moved, &instance.translate_m, COORDINATE, "m")?;
    numbers(
        &at.field("rotate_deg"),
        &instance.rotate_deg,
        TURN,
        "degrees",
    )?;
    let scale_at = at.field("scale");
    for (axis, &factor) in instance.scale.iter().enumerate() {
        let axis_at = scale_at.index(axis);
        // A scale of 1e-7 is a flat mesh in f32; its inverse must stay usable.
        if !(1e-6..=1e6).contains(&factor.abs()) {
            return Err(axis_at.error(format!(
                "{factor}: expected 1e-6 to 1e6 in size, with either sign"
            )));
        }
    }
    Ok(())
}

fn sky(at: &At<'_>, sky: &Sky) -> Result<(), SceneError> {
    match sky {
        Sky::Constant(sky) => numbers(&at.field("radiance"), &sky.radiance, RADIANCE, ""),
        Sky::Map(sky) => {
            asset(&at.field("file"), &sky.file)?;
            number(&at.field("rotation_deg"), sky.rotation_deg, TURN, "degrees")?;
            number(&at.field("intensity"), sky.intensity, RADIANCE, "")
        }
    }
}

fn sun(at: &At<'_>, sun: &Sun) -> Result<(), SceneError> {
    number(&at.field("azimuth_deg"), sun.azimuth_deg, TURN, "degrees")?;
    let elevation = Range::Closed(-90.0, 90.0);
    let elevation_at = at.field("elevation_deg");
    number(&elevation_at, sun.elevation_deg, elevation, "degrees")?;
    let radius = Range::Above(0.0, 45.0);
    let radius_at = at.field("angular_radius_deg");
    number(&radius_at, sun.angular_radius_deg, radius, "degrees")?;
    numbers(&at.field("radiance"), &sun.radiance, RADIANCE, "")
}

fn water(at: &At<'_>, water: &Water) -> Result<(), SceneError> {
    let Water::Tessendorf(w) = water;
    number(&at.field("height_m"), w.height_m, COORDINATE, "m")?;
    if !(16..=2048).contains(&w.grid) || !w.grid.is_power_of_two() {
        return Err(at
            .field("grid")
            .error(format!("{}: expected a power of two, 16 to 2048", w.grid)));
    }
    number(&at.field("tile_m"), w.tile_m, TILE_M, "m")?;
    number(
        &at.field("wind_speed_mps"),
        w.wind_speed_mps,
        WIND_MPS,
        "m/s",
    )?;
    let wind_at = at.field("wind_direction_deg");
    number(&wind_at, w.wind_direction_deg, TURN, "degrees")?;
    number(
        &at.field("amplitude"),
        w.amplitude,
        Range::Closed(0.0, 10.0),
        "",
    )?;
    number(&at.field("cutoff_m"), w.cutoff_m, LENGTH, "m")?;
    numbers(&at.field("body_color"), &w.body_color, SHARE, "")?;
    number(&at.field("ior"), w.ior, Range::Closed(1.0, 4.0), "")?;
    number(&at.field("roughness"), w.roughness, SHARE, "")?;
    numbers(
        &at.field("velocity_mps"),
        &w.velocity_mps,
        VELOCITY_MPS,
        "m/s",
    )?;
    number(&at.field("time_s"), w.time_s, Range::Closed(-1e6, 1e6), "s")
}

fn clouds(at: &At<'_>, clouds: &[Cloud]) -> Result<(), SceneError> {
    let most = limits::PARTICLES_MAX as u64;
    let mut particles = 0_u64;
    for (i, described) in clouds.iter().enumerate() {
        cloud(&at.index(i), described)?;
        particles += u64::from(described.count);
        if particles > most {
            return Err(at.index(i).field("count").error(format!(
                "{particles} particles in all clouds so far: expected at most {most}"
            )));
        }
    }
    Ok(())
}

fn cloud(at: &At<'_>, cloud: &Cloud) -> Result<(), SceneError> {
    numbers(&at.field("centre_m"), &cloud.centre_m, COORDINATE, "m")?;
    numbers(&at.field("radii_m"), &cloud.radii_m, SIZE, "m")?;
    direction(&at.field("direction"), &cloud.direction)?;
    number(&at.field("length_m"), cloud.length_m, LENGTH, "m")?;
    let most = limits::PARTICLES_MAX as u64;
    count(&at.field("count"), cloud.count.into(), 1, most)?;
    let radius_at = at.field("particle_radius_m");
    bounds(&radius_at, &cloud.particle_radius_m, SIZE, "m")?;
    let stretch = Range::Closed(1e-3, 1e3);
    bounds(&at.field("stretch_x"), &cloud.stretch_x, stretch, "")?;
    bounds(&at.field("opacity"), &cloud.opacity, SHARE, "")?;
    numbers(&at.field("albedo"), &cloud.albedo, SHARE, "")
}

fn post(at: &At<'_>, post: &Post) -> Result<(), SceneError> {
    let exposure = Range::Closed(-32.0, 32.0);
    number(
        &at.field("exposure_ev"),
        post.exposure_ev,
        exposure,
        "stops",
    )?;
    let Some(bloom) = &post.bloom else {
        return Ok(());
    };
    let at = at.field("bloom");
    number(&at.field("threshold"), bloom.threshold, RADIANCE, "")?;
    let strength = Range::Closed(0.0, limits::BLOOM_STRENGTH_MAX.into());
    number(&at.field("strength"), bloom.strength, strength, "")?;
    let radius = "of the picture's height";
    number(&at.field("radius"), bloom.radius, SHARE, radius)?;
    count(
        &at.field("passes"),
        bloom.passes.into(),
        1,
        limits::BLOOM_PASSES_MAX.into(),
    )
}

#[cfg(test)]
#[path = "validate_tests.rs"]
mod tests;
