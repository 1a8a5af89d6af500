"""Renders an export with Cycles (the `bpy` package) on one thread and writes pictures
and seconds.

    cycles_render.py EXPORT OUT --size 256x128 --spp 4,16,64 [--reference 1024]

Set-up is not timed: a call with one sample gives what a call costs beside its samples.
"""

import argparse
import math
import os
import re
import tempfile

import bpy
import numpy as np
from mathutils import Matrix, Vector

import exported

WATER_REACH_M = 2e5
# Scattering events; the tail beyond is lost in the noise.
BOUNCES = 64
# Its own limit; passing through a cloud costs one of these at each wall.
TRANSPARENT_BOUNCES = 1024
# Sides of the mesh that stands for a particle: 1280 triangles, smooth normals.
PARTICLE_SUBDIVISIONS = 4


def tree_of(material):
    material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    return tree


def output(tree, shader):
    node = tree.nodes.new("ShaderNodeOutputMaterial")
    tree.links.new(shader, node.inputs["Surface"])


def image(path, raw):
    loaded = bpy.data.images.load(str(path))
    loaded.colorspace_settings.name = "Non-Color" if raw else "sRGB"
    return loaded


def principled(tree, base, alpha, metalness, f0):
    node = tree.nodes.new("ShaderNodeBsdfPrincipled")
    node.inputs["Base Color"].default_value = (*base, 1.0)
    node.inputs["Roughness"].default_value = alpha**0.5
    node.inputs["Metallic"].default_value = metalness
    root = f0**0.5
    node.inputs["IOR"].default_value = (1.0 + root) / (1.0 - root)
    return node


def surface(scene, described, cache):
    key = str(described)
    if key in cache:
        return cache[key]
    base, texture, alpha, metalness, f0 = exported.metal_or_not(described)
    material = bpy.data.materials.new("surface")
    tree = tree_of(material)
    if alpha is None:
        node = tree.nodes.new("ShaderNodeBsdfDiffuse")
        node.inputs["Color"].default_value = (*base, 1.0)
        tinted = node.inputs["Color"]
    else:
        node = principled(tree, base, alpha, metalness, f0)
        tinted = node.inputs["Base Color"]
    if texture:
        picture = tree.nodes.new("ShaderNodeTexImage")
        picture.image = image(scene["folder"] / scene["textures"][texture], False)
        tree.links.new(picture.outputs["Color"], tinted)
    output(tree, node.outputs[0])
    cache[key] = material
    return material


def mesh_object(name, positions, normals, uvs, triangles, material):
    mesh = bpy.data.meshes.new(name)
    count = len(triangles)
    mesh.vertices.add(len(positions))
    mesh.vertices.foreach_set("co", np.ascontiguousarray(positions, np.float32).ravel())
    mesh.loops.add(3 * count)
    mesh.loops.foreach_set("vertex_index", np.ascontiguousarray(triangles, np.int32).ravel())
    mesh.polygons.add(count)
    mesh.polygons.foreach_set("loop_start", np.arange(0, 3 * count, 3, dtype=np.int32))
    if uvs is not None:
        layer = mesh.uv_layers.new(name="uv")
        layer.data.foreach_set("uv", np.ascontiguousarray(uvs[triangles.ravel()]).ravel())
    mesh.update(calc_edges=True)
    mesh.validate()
    if normals is not None:
        mesh.normals_split_custom_set_from_vertices(np.asarray(normals, np.float64).tolist())
    mesh.materials.append(material)
    made = bpy.data.objects.new(name, mesh)
    bpy.context.collection.objects.link(made)
    return made


def meshes(scene):
    cache = {}
    for number, described in enumerate(scene["meshes"]):
        shape = exported.ply(scene["folder"] / described["file"])
        material = surface(scene, described["material"], cache)
        mesh_object(f"mesh{number}", *shape, material)


def water(scene):
    look = scene["water"]
    if not look:
        return
    material = bpy.data.materials.new("water")
    tree = tree_of(material)
    node = principled(tree, look["body_color"], look["roughness"] ** 2, 0.0, 0.02)
    node.inputs["IOR"].default_value = look["ior"]
    if look["normals"]:
        wave_normals(scene, tree, node)
    output(tree, node.outputs[0])
    r, y = WATER_REACH_M, look["height_m"]
    corners = np.float32([[-r, y, -r], [-r, y, r], [r, y, r], [r, y, -r]])
    triangles = np.int32([[0, 1, 2], [0, 2, 3]])
    mesh_object("water", corners, None, None, triangles, material)


def wave_normals(scene, tree, node):
    """The map by position, not by uv: a plane of 400 km has no digits left for those.
    Its picture holds n / 2 + 1 / 2 along x, y, z."""
    normals = scene["water"]["normals"]
    values = exported.exr(
        scene["folder"] / normals["file"], ("normal.X", "normal.Y", "normal.Z")
    )
    side = normals["points"]
    picture = bpy.data.images.new("waves", side, side, float_buffer=True, is_data=True)
    # Blender's rows run upwards: row 0 is z = 0, as in the map.
    pixels = np.ones((side, side, 4), np.float32)
    pixels[..., :3] = values * 0.5 + 0.5
    picture.pixels.foreach_set(pixels.ravel())
    picture.pack()
    new = tree.nodes.new
    where = new("ShaderNodeNewGeometry")
    turn = new("ShaderNodeMapping")
    turn.vector_type = "POINT"
    size = normals["side_m"]
    x0, z0 = normals["origin_m"]
    half = 0.5 / side
    # (x, y, z) to (x, z, y): a quarter turn would change a sign.
    split, join = new("ShaderNodeSeparateXYZ"), new("ShaderNodeCombineXYZ")
    tree.links.new(where.outputs["Position"], split.inputs[0])
    tree.links.new(split.outputs["X"], join.inputs["X"])
    tree.links.new(split.outputs["Z"], join.inputs["Y"])
    tree.links.new(join.outputs[0], turn.inputs["Vector"])
    turn.inputs["Scale"].default_value = (1.0 / size, 1.0 / size, 1.0)
    turn.inputs["Location"].default_value = (half - x0 / size, half - z0 / size, 0.0)
    lookup = new("ShaderNodeTexImage")
    lookup.image = picture
    tree.links.new(turn.outputs["Vector"], lookup.inputs["Vector"])
    unpack = new("ShaderNodeVectorMath")
    unpack.operation = "MULTIPLY_ADD"
    unpack.inputs[1].default_value = (2.0, 2.0, 2.0)
    unpack.inputs[2].default_value = (-1.0, -1.0, -1.0)
    tree.links.new(lookup.outputs["Color"], unpack.inputs[0])
    tree.links.new(unpack.outputs[0], node.inputs["Normal"])


def clouds(scene):
    """Smooth spheres of triangles, instanced; opacity and albedo by the object."""
    rows = exported.particles(scene)
    if rows is None:
        return
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=PARTICLE_SUBDIVISIONS, radius=1.0)
    sphere = bpy.context.object
    mesh = sphere.data
    bpy.data.objects.remove(sphere)
    mesh.polygons.foreach_set("use_smooth", np.ones(len(mesh.polygons), bool))
    material = bpy.data.materials.new("cloud")
    tree = tree_of(material)
    clear, white = (tree.nodes.new(f"ShaderNodeBsdf{k}") for k in ("Transparent", "Diffuse"))
    info, mix = tree.nodes.new("ShaderNodeObjectInfo"), tree.nodes.new("ShaderNodeMixShader")
    tree.links.new(info.outputs["Color"], white.inputs["Color"])
    tree.links.new(info.outputs["Alpha"], mix.inputs[0])
    tree.links.new(clear.outputs[0], mix.inputs[1])
    tree.links.new(white.outputs[0], mix.inputs[2])
    output(tree, mix.outputs[0])
    mesh.materials.append(material)
    for number, row in enumerate(rows):
        made = bpy.data.objects.new(f"cloud{number}", mesh)
        made.location, made.scale = row[0:3].tolist(), row[3:6].tolist()
        made.color = (*row[7:10].tolist(), float(row[6]))
        bpy.context.collection.objects.link(made)


def lights(scene):
    sun, sky = scene["sun"], scene["sky"]
    world = bpy.data.worlds.new("sky")
    bpy.context.scene.world = world
    world.use_nodes = True
    tree = world.node_tree
    tree.nodes.clear()
    out = tree.nodes.new("ShaderNodeOutputWorld")
    ground = tree.nodes.new("ShaderNodeBackground")
    tree.links.new(ground.outputs[0], out.inputs["Surface"])
    if sky:
        picture = tree.nodes.new("ShaderNodeTexEnvironment")
        picture.image = image(scene["folder"] / sky["file"], True)
        # Its map has z up, its middle column looks along +x and its columns grow
        # towards -y: (x, y, z) of ours is (-z, -x, y) of its.
        join, split = (tree.nodes.new(f"ShaderNode{k}XYZ") for k in ("Combine", "Separate"))
        coordinates = tree.nodes.new("ShaderNodeTexCoord")
        tree.links.new(coordinates.outputs["Generated"], split.inputs[0])
        for there, here in (("X", "Z"), ("Y", "X")):
            minus = tree.nodes.new("ShaderNodeMath")
            minus.operation = "MULTIPLY"
            minus.inputs[1].default_value = -1.0
            tree.links.new(split.outputs[here], minus.inputs[0])
            tree.links.new(minus.outputs[0], join.inputs[there])
        tree.links.new(split.outputs["Y"], join.inputs["Z"])
        tree.links.new(join.outputs[0], picture.inputs["Vector"])
        tree.links.new(picture.outputs["Color"], ground.inputs["Color"])
        world.cycles.sampling_method = "AUTOMATIC"
    if sun:
        lamp = bpy.data.lights.new("sun", "SUN")
        angle = math.radians(sun["angular_radius_deg"])
        lamp.angle = 2.0 * angle
        radiance = np.array(sun["radiance"])
        # Its strength is the irradiance square to it: L pi sin^2 of the radius.
        irradiance = radiance * math.pi * math.sin(angle) ** 2
        lamp.energy = float(irradiance.max())
        lamp.color = (irradiance / irradiance.max()).tolist()
        made = bpy.data.objects.new("sun", lamp)
        direction = Vector(sun["direction"])
        made.rotation_mode = "QUATERNION"
        # A lamp shines along its -z.
        made.rotation_quaternion = direction.to_track_quat("Z", "Y")
        bpy.context.collection.objects.link(made)


def camera(scene):
    described = scene["camera"]
    made = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    eye, target = (Vector(described[k]) for k in ("position_m", "target_m"))
    back = (eye - target).normalized()
    right = Vector(described["up"]).cross(back).normalized()
    up = back.cross(right)
    rotation = Matrix((right, up, back)).transposed()
    made.matrix_world = Matrix.Translation(eye) @ rotation.to_4x4()
    made.data.sensor_fit = "VERTICAL"
    made.data.angle = math.radians(described["vertical_fov_deg"])
    made.data.clip_start, made.data.clip_end = 0.01, 1e7
    bpy.context.collection.objects.link(made)
    bpy.context.scene.camera = made


def settings(size, threads):
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.render.resolution_x, scene.render.resolution_y = size
    scene.render.resolution_percentage = 100
    scene.render.threads_mode = "FIXED"
    scene.render.threads = threads
    scene.render.use_persistent_data = True
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.image_settings.color_depth = "32"
    scene.render.filter_size = 0.01
    cycles = scene.cycles
    cycles.device = "CPU"
    cycles.pixel_filter_type = "BOX"
    cycles.filter_width = 1.0
    cycles.use_adaptive_sampling = False
    cycles.use_denoising = False
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = 0.0
    cycles.blur_glossy = 0.0
    cycles.caustics_reflective = cycles.caustics_refractive = True
    for kind in ("max", "diffuse", "glossy", "transmission", "volume"):
        setattr(cycles, f"{kind}_bounces", BOUNCES)
    cycles.transparent_max_bounces = TRANSPARENT_BOUNCES
    cycles.use_auto_tile = False


def render(spp, seed, folder):
    scene = bpy.context.scene
    scene.cycles.samples, scene.cycles.seed = spp, seed
    path = os.path.join(folder, f"{spp}-{seed}.exr")
    scene.render.filepath = path
    bpy.ops.render.render(write_still=True)
    return exported.exr(path)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("export")
    parser.add_argument("out")
    parser.add_argument("--size", default="256x128")
    parser.add_argument("--spp", default="4,16,64")
    parser.add_argument("--reference", type=int)
    parser.add_argument("--threads", type=int, default=1)
    args = parser.parse_args()
    size = tuple(int(v) for v in args.size.split("x"))
    # As `--factory-startup`: nobody's own settings, and an empty scene.
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = exported.load(args.export)
    settings(size, args.threads)
    for part in (camera, meshes, water, clouds, lights):
        part(scene)
    facts = {"renderer": f"Cycles {bpy.app.version_string}", "size": size}
    with tempfile.TemporaryDirectory() as folder:
        one = lambda spp, seed: exported.timed(lambda: render(spp, seed, folder))
        _, first, _ = one(1, 5)
        # With the scene kept, a call of one sample: what a call costs by itself.
        _, wall, cpu = one(1, 6)
        facts |= {"setup": first, "call": wall}
        record = exported.Record(args.out, facts)
        if args.reference:
            picture, *seconds = one(args.reference, 1_000_003)
            record.add(f"reference-{args.size}", picture, args.reference, *seconds)
            record.write(f"reference-{args.size}")
            return
        for spp in (int(v) for v in args.spp.split(",")):
            picture, more_wall, more_cpu = one(spp, 11)
            share = spp / max(spp - 1, 1)
            record.add(f"{args.size}-{spp}", picture, spp,
                       (more_wall - wall) * share, (more_cpu - cpu) * share)
        record.write(args.size)


main()
