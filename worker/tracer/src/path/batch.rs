//! Eight paths of one pixel, advanced together: camera rays and first sun rays
//! are coherent and go in packets; everything later goes one by one.

use super::direct::{ShadowRay, sample_sky, sample_sun};
use super::escape::{Choice, escaped_radiance, ray_under_sky};
use super::flight::{Met, Purpose, collide, passed_by_volumes, volume_key};
use super::vertex::Vertex;
use crate::geometry::{Hit, Occlusion, Ray};
use crate::math::elementary::exp;
use crate::sampler::SampleStream;
use crate::scene::Scene;
use crate::uses;
use glam::Vec3;
use shearwater_shared::film::FEATURE_CHANNELS;
use shearwater_shared::limits::PATH_DEPTH_MAX;

/// Paths of a batch: the width of a ray packet.
pub(crate) const LANES: usize = 8;

/// Widest angle of a ray cone after scattering, in radians.
const CONE_ANGLE_MAX: f32 = 0.5;

/// What one path found.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct PathResult {
    /// Radiance, linear RGB.
    pub(crate) radiance: Vec3,
    /// Features of the first hit, as in [`shearwater_shared::film::TileSums`].
    pub(crate) features: [f32; FEATURE_CHANNELS],
    /// The path ended at the safety cap on its depth, or on steps through volumes.
    pub(crate) depth_capped: bool,
}

#[derive(Clone, Copy)]
struct Path {
    ray: Ray,
    stream: SampleStream,
    throughput: Vec3,
    choice: Choice,
    /// Width of the ray's cone at its origin in metres, and its angle.
    cone_m: f32,
    cone_rad: f32,
    alive: bool,
}

/// Trace the samples `indices` (at most [`LANES`]) of pixel (x, y). `USES`
/// says what the scene uses.
pub(crate) fn trace_batch<const USES: u8>(
    scene: &Scene,
    x: u32,
    y: u32,
    streams: &[SampleStream],
    results: &mut [PathResult; LANES],
) {
    let Some(&first) = streams.first() else {
        return;
    };
    // Lanes beyond the last sample repeat the first and are thrown away.
    let mut paths: [Path; LANES] = std::array::from_fn(|i| {
        camera_path::<USES>(scene, x, y, *streams.get(i).unwrap_or(&first))
    });
    *results = [PathResult::default(); LANES];
    for path in &mut paths[streams.len().min(LANES)..] {
        path.alive = false;
    }
    let hits = camera_hits::<USES>(scene, &paths);
    let mut sun_rays: [Option<ShadowRay>; LANES] = [None; LANES];
    for lane in 0..LANES {
        if paths[lane].alive {
            sun_rays[lane] =
                first_vertex::<USES>(scene, &mut paths[lane], hits[lane], &mut results[lane]);
        }
    }
    let sun_keys = std::array::from_fn(|i| volume_key::<USES>(&paths[i].stream, 0, Purpose::ToSun));
    sun_packet::<USES>(scene, &sun_rays, &sun_keys, results);
    for (path, result) in paths.iter_mut().zip(results) {
        finish::<USES>(scene, path, result);
    }
}

#[inline]
fn camera_path<const USES: u8>(scene: &Scene, x: u32, y: u32, stream: SampleStream) -> Path {
    let [dx, dy, time, _] = stream.camera();
    let lens = if scene.camera.has_lens() {
        stream.lens()
    } else {
        [0.0; 4]
    };
    let time_s = scene.camera.time_s(time);
    let (o, d) = scene
        .camera
        .ray::<USES>(x as f32 + dx, y as f32 + dy, [lens[0], lens[1]], time_s);
    Path {
        ray: ray_under_sky::<USES>(scene, o, d, time_s),
        stream,
        throughput: Vec3::ONE,
        choice: Choice::ALONE,
        cone_m: 0.0,
        cone_rad: scene.camera.pixel_angle_rad,
        alive: true,
    }
}

#[inline]
fn camera_hits<const USES: u8>(scene: &Scene, paths: &[Path; LANES]) -> [Option<Hit>; LANES] {
    let rays = std::array::from_fn(|lane| paths[lane].ray);
    let keys = std::array::from_fn(|lane| paths[lane].stream.segment_key(0));
    scene.geometry.intersect8::<USES>(&rays, &keys)
}

// The first vertex: features, the sky's shadow ray at once, the sun's for the
// packet.
#[inline]
fn first_vertex<const USES: u8>(
    scene: &Scene,
    path: &mut Path,
    hit: Option<Hit>,
    result: &mut PathResult,
) -> Option<ShadowRay> {
    let key = volume_key::<USES>(&path.stream, 0, Purpose::Flight);
    let limit = hit.map_or(path.ray.t_max, |hit| hit.t);
    let Ok(collision) = collide::<USES>(scene, &path.ray, limit, key) else {
        result.depth_capped = true;
        path.alive = false;
        return None;
    };
    let Some(met) = Met::nearer(hit, collision) else {
        result.radiance = escaped_radiance(scene, &path.ray, path.choice);
        path.alive = false;
        return None;
    };
    let at = interact::<USES>(scene, path, &met);
    let (albedo, normal) = (at.albedo(), at.frame.normal);
    result.features = [
        albedo.x,
        albedo.y,
        albedo.z,
        normal.x,
        normal.y,
        normal.z,
        met.t(),
        1.0,
    ];
    let (sun, sky) = light_rays::<USES>(scene, path, &at, 0);
    let sky_key = volume_key::<USES>(&path.stream, 0, Purpose::ToSky);
    add_if_seen::<USES>(scene, sky, sky_key, result);
    scatter::<USES>(scene, path, &at, 0);
    sun
}

#[inline]
fn sun_packet<const USES: u8>(
    scene: &Scene,
    sun_rays: &[Option<ShadowRay>; LANES],
    keys: &[u64; LANES],
    results: &mut [PathResult; LANES],
) {
    // A packet pays from two rays on; the empty lanes repeat a ray.
    let Some(some) = sun_rays.iter().flatten().next() else {
        return;
    };
    if sun_rays.iter().flatten().count() == 1 {
        for ((ray, key), result) in sun_rays.iter().zip(keys).zip(results) {
            add_if_seen::<USES>(scene, *ray, *key, result);
        }
        return;
    }
    let rays = std::array::from_fn(|lane| {
        sun_rays[lane]
            .as_ref()
            .map_or(some.ray, |shadow| shadow.ray)
    });
    let seen = scene.geometry.transmittance_depth8::<USES>(&rays);
    for lane in 0..LANES {
        if let Some(shadow) = &sun_rays[lane] {
            add::<USES>(scene, shadow, seen[lane], keys[lane], &mut results[lane]);
        }
    }
}

// Everything after the first vertex of one path.
fn finish<const USES: u8>(scene: &Scene, path: &mut Path, result: &mut PathResult) {
    let mut depth = 1;
    while path.alive {
        // Volumes first: what is behind a collision need not be looked for.
        let volume_key = |purpose| volume_key::<USES>(&path.stream, depth, purpose);
        let flight_key = volume_key(Purpose::Flight);
        let keys = [Purpose::ToSun, Purpose::ToSky].map(volume_key);
        let Ok(collision) = collide::<USES>(scene, &path.ray, path.ray.t_max, flight_key) else {
            result.depth_capped = true;
            return;
        };
        if let Some(collision) = &collision {
            path.ray.t_max = collision.t;
        }
        let key = path.stream.segment_key(depth);
        let hit = scene.geometry.intersect::<USES>(&path.ray, key);
        let Some(met) = Met::nearer(hit, collision) else {
            result.radiance += path.throughput * escaped_radiance(scene, &path.ray, path.choice);
            return;
        };
        if depth >= PATH_DEPTH_MAX {
            result.depth_capped = true;
            return;
        }
        let at = interact::<USES>(scene, path, &met);
        let (sun, sky) = light_rays::<USES>(scene, path, &at, depth);
        add_if_seen::<USES>(scene, sun, keys[0], result);
        add_if_seen::<USES>(scene, sky, keys[1], result);
        scatter::<USES>(scene, path, &at, depth);
        depth += 1;
    }
}

#[inline]
fn interact<const USES: u8>(scene: &Scene, path: &mut Path, met: &Met) -> Vertex {
    path.cone_m += path.cone_rad * met.t();
    met.vertex::<USES>(scene, &path.ray, path.cone_m)
}

#[inline]
fn light_rays<const USES: u8>(
    scene: &Scene,
    path: &mut Path,
    at: &Vertex,
    depth: u32,
) -> (Option<ShadowRay>, Option<ShadowRay>) {
    // A perfect mirror has no density that light sampling could hit.
    let sampled = !at.is_delta::<USES>();
    path.choice.sun_sampled = sampled && scene.common.sample_sun;
    path.choice.sky_sampled = sampled
        && scene.common.sample_sky
        && (at.light_sampling_pays::<USES>() || scene.common.strategy.sky_from_everywhere);
    if !sampled {
        return (None, None);
    }
    if !(path.choice.sun_sampled || path.choice.sky_sampled) {
        return (None, None);
    }
    let u = path.stream.lights(depth);
    let sun = if path.choice.sun_sampled {
        sample_sun::<USES>(scene, at, path.ray.time_s, path.throughput, [u[0], u[1]])
    } else {
        None
    };
    let sun = sun.and_then(|shadow| worth_tracing(scene, shadow, path, depth));
    let sky = if path.choice.sky_sampled {
        sample_sky::<USES>(scene, at, path.ray.time_s, path.throughput, [u[2], u[3]])
    } else {
        None
    };
    (sun, sky)
}

// Most light samples of a mirror-like surface are the far tail of its lobe and add
// next to nothing: those are traced with a chance in proportion to what they add,
// and count for more in return (Russian roulette, unbiased).
#[inline]
fn worth_tracing(
    scene: &Scene,
    mut shadow: ShadowRay,
    path: &Path,
    depth: u32,
) -> Option<ShadowRay> {
    let strongest = shadow.contribution.max_element();
    if strongest >= scene.common.faint {
        return Some(shadow);
    }
    let chance = strongest / scene.common.faint;
    if path.stream.roulette(depth) >= chance {
        return None;
    }
    shadow.contribution /= chance;
    Some(shadow)
}

#[inline]
fn add_if_seen<const USES: u8>(
    scene: &Scene,
    shadow: Option<ShadowRay>,
    volume_key: u64,
    result: &mut PathResult,
) {
    if let Some(shadow) = shadow {
        let occlusion = scene.geometry.transmittance_depth::<USES>(&shadow.ray);
        add::<USES>(scene, &shadow, occlusion, volume_key, result);
    }
}

#[inline]
fn add<const USES: u8>(
    scene: &Scene,
    shadow: &ShadowRay,
    occlusion: Occlusion,
    volume_key: u64,
    result: &mut PathResult,
) {
    let passed = transmittance(occlusion);
    if USES & uses::MEDIA == 0 {
        result.radiance += shadow.contribution * passed;
    } else if passed > 0.0 {
        let capped = &mut result.depth_capped;
        let volumes = passed_by_volumes::<USES>(scene, &shadow.ray, volume_key, capped);
        result.radiance += shadow.contribution * (passed * volumes);
    }
}

#[inline]
fn transmittance(occlusion: Occlusion) -> f32 {
    if occlusion.is_blocked() {
        0.0
    } else if occlusion == Occlusion::CLEAR {
        1.0
    } else {
        exp(occlusion.depth() as f32 * (-1.0 / crate::geometry::OPTICAL_DEPTH_SCALE))
    }
}

// The next direction of the path, or its end.
#[inline]
fn scatter<const USES: u8>(scene: &Scene, path: &mut Path, at: &Vertex, depth: u32) {
    let u = path.stream.scatter(depth);
    path.alive = false;
    let Some(sample) = at.sample::<USES>(&scene.common.tables, [u[0], u[1], u[2]]) else {
        return;
    };
    let wi = sample.wi;
    path.throughput *= sample.weight;
    // Black; NaN goes on, to be counted as a bad sample.
    if path.throughput == Vec3::ZERO {
        return;
    }
    let (kept, carried) = (sample.weight.max_element(), path.throughput.max_element());
    if let Some(survival) = scene
        .common
        .strategy
        .roulette
        .survival(depth, kept, carried)
    {
        if u[3] >= survival {
            return;
        }
        path.throughput /= survival;
    }
    path.choice.pdf = sample.pdf;
    if sample.delta {
        path.choice = Choice::ALONE;
    } else {
        // The solid angle 1 / pdf of a lobe is a cone of angle 1 / sqrt(pi pdf).
        path.cone_rad = path
            .cone_rad
            .max((0.25 / sample.pdf.max(1e-6)).sqrt())
            .min(CONE_ANGLE_MAX);
    }
    path.ray = ray_under_sky::<USES>(
        scene,
        at.point.origin_towards(wi),
        wi.normalize(),
        path.ray.time_s,
    );
    path.alive = true;
}
