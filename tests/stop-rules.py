"""The tables of docs/stop-rules.md, from what tests/stop-rules has rendered.

    tests/stop-rules.py ADAPTIVE UNIFORM...

Each is a folder with figures.json (of `shearwater render`) and compare.json.
"""

import json
import math
import sys
from pathlib import Path


def read(folder):
    """Figures of one render; its error without the reference's own noise."""
    figures = json.loads((Path(folder) / "figures.json").read_text())
    compared = json.loads((Path(folder) / "compare.json").read_text())
    own = compared["reference_rel_mse"]
    return {
        "samples": figures["samples_mean"],
        "least": figures["samples_min"],
        "most": figures["samples_max"],
        "core_s": figures["core_seconds"],
        "cpu_s": figures["cpu_seconds"],
        "wall_s": figures["seconds"],
        "estimated": figures["error"]["relmse"],
        "rel_mse": compared["rel_mse"] - own,
        "trimmed": compared["rel_mse_trimmed"],
        "own": own,
        "groups": compared["groups"],
    }


def at_error(uniform, measure, key, error):
    """What equal samples everywhere need for `error`: on the line between the nearest
    two measured, log against log; beyond them it says so."""
    points = sorted((u[measure], u[key]) for u in uniform)
    pairs = list(zip(points, points[1:]))
    (e0, v0), (e1, v1) = next(
        (pair for pair in pairs if pair[0][0] <= error <= pair[1][0]),
        pairs[0] if error < points[0][0] else pairs[-1],
    )
    share = math.log(error / e0) / math.log(e1 / e0)
    inside = points[0][0] <= error <= points[-1][0]
    return math.exp(math.log(v0) + share * math.log(v1 / v0)), inside


def main():
    adaptive, *uniform = [read(folder) for folder in sys.argv[1:]]
    print("| samples | core s | CPU s | wall s | relMSE | trimmed | as the halves say |")
    print("|---|---|---|---|---|---|---|")
    for row, name in [(adaptive, "error stop: "), *((u, "") for u in uniform)]:
        samples = f"{row['samples']:.0f}"
        if row["least"] != row["most"]:
            samples += f" ({row['least']} to {row['most']})"
        print(
            f"| {name}{samples} | {row['core_s']:.1f} | {row['cpu_s']:.1f} | {row['wall_s']:.1f}"
            f" | {row['rel_mse']:.3e} | {row['trimmed']:.3e} | {row['estimated']:.3e} |"
        )
    print(f"\nThe reference's own relMSE, subtracted from the first: {adaptive['own']:.2e}.\n")
    print("Equal samples for the error stop's error, and the error stop's share of that:\n")
    keys = {"core_s": "core s", "cpu_s": "CPU s", "wall_s": "wall s", "samples": "samples"}
    print("| error | " + " | ".join(keys.values()) + " |\n|---|---|---|---|---|")
    measures = {"rel_mse": "relMSE", "trimmed": "trimmed", "estimated": "as the halves say"}
    for measure, name in measures.items():
        cells = []
        for key in keys:
            value, inside = at_error(uniform, measure, key, adaptive[measure])
            cells.append(f"{value:.1f}{'' if inside else ' (ext.)'}: **{adaptive[key] / value:.2f}**")
        print(f"| {name} | " + " | ".join(cells) + " |")
    print("\n| samples | tiles | mean difference | z | relative | z | relMSE | the reference's |")
    print("|---|---|---|---|---|---|---|---|")
    for group in adaptive["groups"]:
        mean, relative = group["difference"], group["relative_difference"]
        print(
            f"| {group['samples_min']} | {group['tiles']}"
            f" | {mean['mean']:+.2e} ± {mean['interval_95']:.1e} | {mean['z']:+.2f}"
            f" | {relative['mean']:+.2e} ± {relative['interval_95']:.1e} | {relative['z']:+.2f}"
            f" | {group['rel_mse']:.2e} | {group['reference_rel_mse']:.1e} |"
        )


main()
