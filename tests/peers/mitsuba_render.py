"""Renders an export with Mitsuba 3 on one thread and writes pictures and seconds.

    mitsuba_render.py EXPORT OUT --size 256x128 --spp 4,16,64 [--reference 4096]

Set-up is not timed: loading, compiling, and what a call takes beside its samples.
"""

import argparse
import os

# Its one-thread arithmetic libraries must not start threads of their own.
os.environ.setdefault("OMP_NUM_THREADS", "1")

import drjit as dr
import mitsuba as mi
import numpy as np

import exported

# As far as the plane reaches; ours has no end.
WATER_REACH_M = 2e5
# Far enough that the sun's direction is the same all over the scene.
SUN_DISTANCE_M = 1e7
# The middle column of its sky looks along +z, that of the export along -z.
SKY_TURN_DEG = 180.0
# Samples of a call that measures what a call takes by itself.
FEW = 1
# Samples of one call: the arrays of a wavefront live in memory at once.
WAVEFRONT_MAX = 1 << 24


def srgb_texture(scene, name):
    path = scene["folder"] / scene["textures"][name]
    return {"type": "bitmap", "filename": str(path)}


def color(value):
    return {"type": "rgb", "value": [float(v) for v in value]}


def bsdf(scene, material):
    base, texture, alpha, metalness, f0 = exported.metal_or_not(material)
    tint = srgb_texture(scene, texture) if texture else color(base)
    if alpha is None:
        inner = {"type": "diffuse", "reflectance": tint}
    else:
        inner = principled(tint, alpha, metalness, f0)
    return {"type": "twosided", "nested": inner}


def principled(tint, alpha, metalness, f0):
    root = f0**0.5
    return {
        "type": "principled",
        "base_color": tint,
        "roughness": alpha**0.5,
        "metallic": metalness,
        "eta": (1.0 + root) / (1.0 - root),
    }


def mesh(scene, described):
    return {
        "type": "ply",
        "filename": str(scene["folder"] / described["file"]),
        # Its pictures begin at v = 0 with their top row.
        "flip_tex_coords": True,
        "bsdf": bsdf(scene, described["material"]),
    }


def water(scene):
    look = scene["water"]
    surface = {
        "type": "roughplastic",
        "distribution": "ggx",
        "alpha": look["roughness"] ** 2,
        "int_ior": look["ior"],
        "diffuse_reflectance": color(look["body_color"]),
    }
    if look["normals"]:
        surface = {
            "type": "normalmap",
            "normalmap": {
                "type": "bitmap",
                "data": normal_map(scene),
                "raw": True,
                "to_uv": normal_uv(look["normals"]),
            },
            "bsdf": surface,
        }
    # The rectangle lies in x, y from -1 to 1 and looks along +z; turned about x it
    # looks up, u runs along +x and v along -z.
    to_world = (
        mi.ScalarTransform4f()
        .translate([0.0, look["height_m"], 0.0])
        .rotate([1, 0, 0], -90)
        .scale([WATER_REACH_M, WATER_REACH_M, 1.0])
    )
    return {"type": "rectangle", "to_world": to_world, "bsdf": surface}


def normal_map(scene):
    """(n + 1) / 2 along u, v and out of the water. Rows from v = 0 up: along -z."""
    file = scene["folder"] / scene["water"]["normals"]["file"]
    x, y, z = np.moveaxis(exported.exr(file, ("normal.X", "normal.Y", "normal.Z")), -1, 0)
    tangent = np.stack([x, -z, y], axis=-1)
    return mi.TensorXf(tangent * 0.5 + 0.5)


def normal_uv(normals):
    """From the rectangle's uv to tiles, u along x and v along z (the map's rows)."""
    side, (x0, z0) = normals["side_m"], normals["origin_m"]
    half = 0.5 / normals["points"]
    # x = (2u - 1) reach, z = (1 - 2v) reach; points lie at the corners of texels.
    scale = 2.0 * WATER_REACH_M / side
    move_u = (-WATER_REACH_M - x0) / side + half
    move_v = (WATER_REACH_M - z0) / side + half
    return mi.ScalarTransform3f(
        np.array([[scale, 0, move_u], [0, -scale, move_v], [0, 0, 1]])
    )


def clouds(scene):
    """An analytic sphere for each particle. Mitsuba's cannot be stretched (and its
    `ellipsoids` are hit from outside only, so that clouds stay dark against the sun)."""
    made = {}
    for number, row in enumerate(exported.particles(scene)):
        x, y, z, rx, ry, rz, opacity, *albedo = (float(v) for v in row)
        if max(rx, ry, rz) > 1.001 * min(rx, ry, rz):
            raise SystemExit(f"particle {number} is no sphere: set `stretch_x` to [1, 1]")
        made[f"cloud{number}"] = {
            "type": "sphere",
            "center": [x, y, z],
            "radius": rx,
            "bsdf": {
                "type": "mask",
                "opacity": opacity,
                "nested": {
                    "type": "twosided",
                    "nested": {"type": "diffuse", "reflectance": color(albedo)},
                },
            },
        }
    return made


def lights(scene):
    sun, sky = scene["sun"], scene["sky"]
    made = {}
    if sky:
        made["sky"] = {
            "type": "envmap",
            "filename": str(scene["folder"] / sky["file"]),
            "to_world": mi.ScalarTransform4f().rotate([0, 1, 0], SKY_TURN_DEG),
        }
    if sun:
        centre = np.array(sun["direction"]) * SUN_DISTANCE_M
        radius = SUN_DISTANCE_M * np.sin(np.radians(sun["angular_radius_deg"]))
        made["sun"] = {
            "type": "sphere",
            "center": [float(v) for v in centre],
            "radius": float(radius),
            "emitter": {"type": "area", "radiance": color(sun["radiance"])},
            "bsdf": {"type": "diffuse", "reflectance": color([0, 0, 0])},
        }
    return made


def build(scene, size, with_clouds):
    width, height = size
    camera = scene["camera"]
    made = {
        "type": "scene",
        # `path` lets no light sample through a mask and would need luck to find the
        # sun through a cloud; `volpath` follows it and does not count the crossing.
        "integrator": {
            "type": "volpath" if with_clouds else "path",
            "max_depth": 64,
            "rr_depth": 3,
        },
        "sensor": {
            "type": "perspective",
            "fov": camera["vertical_fov_deg"],
            "fov_axis": "y",
            "near_clip": 0.01,
            "far_clip": 1e8,
            "to_world": mi.ScalarTransform4f().look_at(
                origin=camera["position_m"], target=camera["target_m"], up=camera["up"]
            ),
            "film": {
                "type": "hdrfilm",
                "width": width,
                "height": height,
                "rfilter": {"type": "box"},
                "pixel_format": "rgb",
                "component_format": "float32",
            },
            "sampler": {"type": "multijitter"},
        },
    }
    for number, described in enumerate(scene["meshes"]):
        made[f"mesh{number}"] = mesh(scene, described)
    if scene["water"]:
        made["water"] = water(scene)
    made.update(lights(scene))
    if with_clouds:
        made.update(clouds(scene))
    return mi.load_dict(made)


def render(built, spp, seed):
    """The mean picture. More samples than a wavefront holds come in several calls,
    whose stratification is then each call's own."""
    width, height = built.sensors()[0].film().size()
    most = max(1, WAVEFRONT_MAX // int(width * height))
    total, done = None, 0
    while done < spp:
        some = min(spp - done, most)
        picture = np.array(mi.render(built, spp=some, seed=seed + done))
        total = picture * some if total is None else total + picture * some
        done += some
    return total / spp


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("export")
    parser.add_argument("out")
    parser.add_argument("--size", default="256x128")
    parser.add_argument("--spp", default="4,16,64,256")
    parser.add_argument("--reference", type=int)
    parser.add_argument("--variant", default="llvm_ad_rgb")
    parser.add_argument("--threads", type=int, default=1)
    args = parser.parse_args()
    mi.set_variant(args.variant)
    size = tuple(int(v) for v in args.size.split("x"))
    scene = exported.load(args.export)
    built, setup, _ = exported.timed(
        lambda: build(scene, size, exported.particles(scene) is not None)
    )
    # Only now: with a pool of one thread Mitsuba waits for itself as it reads an EXR.
    dr.set_thread_count(args.threads)
    facts = {"renderer": f"Mitsuba {mi.__version__} {args.variant}", "size": size, "setup": setup}
    record = exported.Record(args.out, facts)
    # The first call with a number of samples compiles its kernel. Each call traces the
    # scene's program anew, seconds with thousands of shapes: set-up as well, so what a
    # call of few samples takes is taken off.
    render(built, FEW, 7)
    _, wall, cpu = exported.timed(lambda: render(built, FEW, 8))
    facts["call"] = wall
    if args.reference:
        result = exported.timed(lambda: render(built, args.reference, 1_000_003))
        record.add(f"reference-{args.size}", result[0], args.reference, *result[1:])
        record.write(f"reference-{args.size}")
        return
    for spp in (int(v) for v in args.spp.split(",")):
        render(built, spp, 7)
        picture, more_wall, more_cpu = exported.timed(lambda: render(built, spp, 100_003))
        share = spp / (spp - FEW)
        record.add(f"{args.size}-{spp}", picture, spp,
                   (more_wall - wall) * share, (more_cpu - cpu) * share)
    record.write(args.size)


main()
