"""Reads what `shearwater export` writes, and what both peers' scripts share."""

import json
import time
from pathlib import Path

import numpy as np


def load(folder):
    """export.json, with `folder` in it."""
    folder = Path(folder)
    scene = json.loads((folder / "export.json").read_text())
    scene["folder"] = folder
    return scene


def particles(scene):
    """One row a particle, with the columns that export.json names; or None."""
    described = scene["particles"]
    if described is None:
        return None
    rows = np.fromfile(scene["folder"] / described["file"], dtype="<f4")
    return rows.reshape(described["count"], len(described["columns"]))


def ply(path):
    """Positions, normals, uv and triangles of a PLY of the export."""
    data = Path(path).read_bytes()
    end = data.index(b"end_header\n") + len(b"end_header\n")
    count = {}
    for line in data[:end].decode().splitlines():
        if line.startswith("element"):
            _, name, number = line.split()
            count[name] = int(number)
    vertices = np.frombuffer(data, "<f4", 8 * count["vertex"], end).reshape(-1, 8)
    face = np.dtype([("n", "u1"), ("v", "<i4", 3)])
    faces = np.frombuffer(data, face, count["face"], end + vertices.nbytes)
    return vertices[:, :3], vertices[:, 3:6], vertices[:, 6:8], faces["v"]


def exr(path, channels=("R", "G", "B")):
    """Rows x columns x channels of an EXR, 32-bit floats."""
    import OpenEXR

    with OpenEXR.File(str(path), separate_channels=True) as file:
        of = file.channels()
        return np.stack([of[c].pixels.astype(np.float32) for c in channels], axis=-1)


def metal_or_not(material):
    """Base colour, its texture or None, GGX alpha, metalness, F0 of the dielectric.

    Phong has no counterpart: GGX of alpha^2 = 2 / (n + 2) stands for it."""
    kind = material["type"]
    if kind == "lambert":
        return material["albedo"], material["albedo_texture"], None, 0.0, 0.0
    if kind == "phong":
        alpha = (2.0 / (material["exponent"] + 2.0)) ** 0.5
        return material["kd"], material["kd_texture"], alpha, 0.0, float(np.mean(material["ks"]))
    return (
        material["base_color"],
        material["base_color_texture"],
        material["roughness"] ** 2,
        material["metalness"] or 0.0,
        material["specular_f0"],
    )


class Record:
    """Pictures and their seconds, one JSON beside them."""

    def __init__(self, folder, facts):
        self.folder = Path(folder)
        self.folder.mkdir(parents=True, exist_ok=True)
        self.facts = {**facts, "pictures": []}

    def add(self, name, picture, spp, seconds, cpu_seconds):
        np.save(self.folder / f"{name}.npy", picture.astype(np.float32))
        entry = {"file": f"{name}.npy", "spp": spp, "seconds": seconds, "cpu_seconds": cpu_seconds}
        self.facts["pictures"].append(entry)
        print(f"  {name}: {spp} spp, {seconds:.2f} s, {cpu_seconds:.2f} s of CPU", flush=True)

    def write(self, name):
        (self.folder / f"{name}.json").write_text(json.dumps(self.facts, indent=1))


def timed(render):
    """What `render` returns, wall seconds, and CPU seconds of all threads."""
    wall, cpu = time.perf_counter(), time.process_time()
    result = render()
    return result, time.perf_counter() - wall, time.process_time() - cpu
