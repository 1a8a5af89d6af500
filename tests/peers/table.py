"""Error and seconds of the pictures below a folder as Markdown tables.

    table.py target/peers

PEERS_TIME=cpu takes CPU seconds instead of wall seconds, for a machine that others use:
less exact, since set-up is subtracted, but not what others took.
"""

import json
import os
import sys
from pathlib import Path

import numpy as np

RENDERERS = ("shearwater", "mitsuba", "cycles")
SCENES = {"plain": "without clouds", "clouds": "with clouds"}
SMALL, LARGE = "256x128", "1024x512"
TARGET = 1e-2
# Share of pixels, the worst, that the trimmed error leaves out.
WORST = 1e-3
# relMSE = mean of (x - r)^2 / (r^2 + EPSILON).
EPSILON = 0.01
SECONDS = "cpu_seconds" if os.environ.get("PEERS_TIME") == "cpu" else "seconds"


def errors(picture, reference):
    """relMSE of all pixels, and without the worst."""
    reference = reference.astype(np.float64)
    each = (picture - reference) ** 2 / (reference**2 + EPSILON)
    each = np.sort(each.mean(axis=-1).ravel())
    kept = each[: len(each) - int(np.ceil(len(each) * WORST))]
    return float(each.mean()), float(kept.mean())


def time_to(points, target):
    """Seconds where the error reaches `target`: a straight line in logarithms through
    the two measured points about it, the first two if it is reached at once. None if it
    is not reached: the error of bright single pixels does not fall evenly."""
    points = sorted(p for p in points if p[0] > 0.0)
    if len(points) < 2:
        return None
    logs = np.log(np.array(points))
    after = next((i for i in range(1, len(points)) if points[i][1] <= target), None)
    if after is None:
        return None
    (t0, e0), (t1, e1) = logs[after - 1], logs[after]
    if e1 >= e0:
        return None
    return float(np.exp(t0 + (np.log(target) - e0) * (t1 - t0) / (e1 - e0)))


def measured(folder):
    """Facts of one renderer on one scene."""
    small = json.loads((folder / f"{SMALL}.json").read_text())
    large = json.loads((folder / f"{LARGE}.json").read_text())
    known = json.loads((folder / f"reference-{SMALL}.json").read_text())["pictures"][0]
    reference = np.load(folder / known["file"])
    rows = []
    for picture in small["pictures"]:
        # The reference has noise too: of errors e/n and e/N their sum is measured.
        own = 1.0 + picture["spp"] / known["spp"]
        whole, kept = errors(np.load(folder / picture["file"]), reference)
        rows.append((picture["spp"], picture[SECONDS], whole / own, kept / own))
    big = large["pictures"][0]
    width, height = (int(v) for v in LARGE.split("x"))
    return {
        "renderer": small["renderer"],
        "rows": rows,
        "rate": width * height * big["spp"] / big[SECONDS] / 1e6,
        "kept": time_to([(r[1], r[3]) for r in rows], TARGET),
        "whole": time_to([(r[1], r[2]) for r in rows], TARGET),
        "reference_spp": known["spp"],
    }


def seconds(value):
    return "not reached" if value is None else f"{value:.2f}"


def main():
    work = Path(sys.argv[1])
    run = json.loads((work / "run.json").read_text())
    print(f"{run['date']}, {run['machine']}, load {run['load']:.1f}, one thread each, {SECONDS.replace('_', ' ')}.\n")
    for scene, text in SCENES.items():
        print(f"Golden Gate {text}:\n")
        print("| renderer | M paths/s, 1024x512 | s to relMSE 1e-2, 256x128 | of all pixels | relMSE (all pixels) at spp | reference spp |")
        print("|---|---|---|---|---|---|")
        all_of = {}
        for renderer in RENDERERS:
            if not (work / scene / renderer / f"{SMALL}.json").exists():
                continue
            m = all_of[renderer] = measured(work / scene / renderer)
            points = ", ".join(f"{n}: {k:.2g} ({w:.2g})" for n, _, w, k in m["rows"])
            print(f"| {m['renderer']} | {m['rate']:.2f} | {seconds(m['kept'])} | {seconds(m['whole'])} | {points} | {m['reference_spp']} |")
        ours = all_of.get("shearwater")
        peers = [m["kept"] for r, m in all_of.items() if r != "shearwater" and m["kept"]]
        if ours and ours["kept"] and peers:
            print(f"\nOurs takes {ours['kept'] / min(peers):.2f} of the fastest peer's time.\n")


main()
