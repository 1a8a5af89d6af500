"""Renders a scene with Shearwater and writes pictures and seconds, as the peers'
scripts do. Set-up is not timed: wall seconds are those of the render threads, CPU
seconds those of the program less a call of two samples.

    shearwater_render.py SCENE.json OUT --program target/release/shearwater --spp 4,16
"""

import argparse
import json
import resource
import subprocess
import tempfile
from pathlib import Path

import exported


def render(args, size, spp, seed):
    with tempfile.TemporaryDirectory() as folder:
        command = [args.program, "--json", "render", args.scene, "--size", size, "--spp", str(spp),
                   "--seed", str(seed), "--threads", str(args.threads), "-o", folder]
        before = cpu_of_children()
        done = subprocess.run(command, capture_output=True, text=True, check=True)
        cpu = cpu_of_children() - before
        result = json.loads(done.stdout)
        (picture,) = (f for f in result["files"] if Path(f).suffix == ".exr")
        return exported.exr(picture), result["core_seconds"], cpu


def cpu_of_children():
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("scene")
    parser.add_argument("out")
    parser.add_argument("--program", default="target/release/shearwater")
    parser.add_argument("--size", default="256x128")
    parser.add_argument("--spp", default="4,16,64,256")
    parser.add_argument("--reference", type=int)
    parser.add_argument("--threads", type=int, default=1)
    args = parser.parse_args()
    version = subprocess.run([args.program, "--version"], capture_output=True, text=True).stdout
    facts = {"renderer": version.strip().capitalize(), "size": args.size}
    record = exported.Record(args.out, facts)
    _, _, setup = render(args, args.size, 2, 3)
    if args.reference:
        picture, seconds, cpu = render(args, args.size, args.reference, 1_000_003)
        record.add(f"reference-{args.size}", picture, args.reference, seconds, cpu - setup)
        record.write(f"reference-{args.size}")
        return
    for spp in (int(v) for v in args.spp.split(",")):
        picture, seconds, cpu = render(args, args.size, spp, 11)
        # The call of two samples had set-up and two samples.
        cpu = (cpu - setup) * spp / (spp - 2)
        record.add(f"{args.size}-{spp}", picture, spp, seconds, cpu)
    record.write(args.size)


main()
