#!/usr/bin/env python3
"""Repeats the experiments of Garland & Heckbert 1995 and puts tables and plots into docs/greedy-insertion.md.

Runs examples/garland_heckbert on Crater Lake (the paper's raster) and, for the growth of the cost, on larger ones. What
is not in the data folder (TERRABITE_DATA, else ../shared/data) is left out, and said so. Plots are made in a virtual
environment of their own.
"""

import json
import math
import subprocess
import sys

from paper_common import DATA, IMAGES, ROOT, TARGET, experiment, fill, grouped, reexec_with_matplotlib, table

TERRABITE = TARGET / "release" / "terrabite"
PAGE = ROOT / "docs" / "greedy-insertion.md"
CRATER = DATA / "crater_lake_garland.tif"
# What the authors' own program gives.
GARLAND = {1: 82828, 5: 19447, 10: 9184, 20: 3979}
LARGER = ["lidar_wetland_1m", "srtm3_S33W071", "srtm3_mosaic_n_england"]


def main():
    if not CRATER.exists():
        sys.exit(f"paper: {CRATER} is not there; set TERRABITE_DATA to the folder that has it")
    reexec_with_matplotlib(__file__)
    tables = {"counts": counts(), "measures": measures(), "cliff": cliff()}
    curves = experiment("garland_heckbert", "curves", CRATER)
    tables["passes"] = at_vertices(curves, ["sequential", "fractional 0.9", "fractional 0.5", "constant 20", "constant 5"])
    tables["swaps"] = swaps(curves)
    plot_curves(curves)
    times = {CRATER.stem: experiment("garland_heckbert", "times", CRATER)}
    for name in LARGER:
        path = DATA / f"{name}.tif"
        if path.exists():
            times[name] = experiment("garland_heckbert", "times", path)
        else:
            print(f"paper: {path} is not there: left out", file=sys.stderr)
    tables["growth"] = growth(times)
    plot_times(times)
    fill(PAGE, tables)


def counts():
    free = {float(r["tolerance"]): int(r["triangles"]) for r in experiment("garland_heckbert", "counts", CRATER, *GARLAND)}
    rows = []
    for tolerance, theirs in GARLAND.items():
        share = [f"{grouped(n)} ({100 * (n / theirs - 1):+.2f} %)" for n in [free[tolerance], simplified(tolerance)]]
        rows.append([tolerance, grouped(theirs), *share])
    return table(["tolerance", "the authors' program", "ours, rim refined likewise", "ours, rim by min-link"], rows)


def simplified(tolerance):
    """Triangles of insertion alone, in one tile."""
    mesh = TARGET / "paper.ply"
    arguments = ["--max-error", tolerance, "--tile", 0, "--engine", "greedy-insertion", "--quality", "none"]
    done = subprocess.run(
        [TERRABITE, "simplify", CRATER, mesh, *map(str, arguments), "--overwrite", "--json"],
        check=True, capture_output=True, text=True,
    )
    mesh.unlink()
    return json.loads(done.stdout)["triangles"]


def measures():
    rows = [[r["measure"], r["vertices"], f"{float(r['rms']):.2f}", f"{float(r['largest']):.1f}"] for r in experiment("garland_heckbert", "measures", CRATER)]
    return table(["measure", "vertices", "RMS error", "maximum error"], rows)


def cliff():
    return table(["variant", "vertices"], [[r["variant"], r["vertices"]] for r in experiment("garland_heckbert", "cliff")])


def nearest(rows, variant, vertices):
    """The step of a variant at so many vertices; None where it ended before."""
    steps = [r for r in rows if r["variant"] == variant and int(r["vertices"]) >= vertices]
    return steps[0] if steps else None


AT = [200, 555, 1000, 2000, 5000, 10000, 19000]


def at_vertices(curves, variants):
    def cell(variant, vertices):
        step = nearest(curves, variant, vertices)
        return "" if step is None else f"{float(step['rms']):.2f} / {float(step['largest']):.1f}"

    return table(["RMS / maximum at", *map(grouped, AT)], [[v, *(cell(v, n) for n in AT)] for v in variants])


def swaps(curves):
    def ratio(variant, vertices):
        ours, delaunay = nearest(curves, variant, vertices), nearest(curves, "sequential", vertices)
        return "" if ours is None else f"{float(ours['rms']) / float(delaunay['rms']):.3f}"

    def mean(variant):
        ratios = [float(ratio(variant, n)) for n in range(500, 19001, 500)]
        return f"{math.exp(sum(map(math.log, ratios)) / len(ratios)):.3f}"

    names = {
        "data-dependent": "max and sum, threshold 0.5",
        "data-dependent, L2": "L2, threshold 0.5",
        "data-dependent, L∞": "L∞, threshold 0.5",
        "data-dependent, pure": "max and sum, threshold 0",
    }
    rows = [[names[v], *(ratio(v, n) for n in AT), mean(v)] for v in names]
    return table(["RMS against Delaunay at", *map(grouped, AT), "mean, 500 to 19 000"], rows)


def growth(times):
    rows = []
    for name, steps in times.items():
        for variant in ["delaunay", "data-dependent"]:
            chosen = [r for r in steps if r["variant"] == variant and int(r["vertices"]) >= 1000]
            per = [
                1e9 * float(r["seconds"]) / ((int(r["vertices"]) + float(r["samples"])) * math.log2(int(r["vertices"])))
                for r in chosen
            ]
            cells = [f"{1e3 * float(r['seconds']):.0f} ms: {p:.1f}" for r, p in zip(chosen, per)]
            cells += [""] * (6 - len(cells))
            rows.append([f"{name}, {variant}", grouped(int(float(chosen[0]["samples"]))), *cells])
    return table(["raster, variant", "samples", "1 000", "2 000", "5 000", "10 000", "20 000", "50 000"], rows)


def plot_curves(curves):
    import matplotlib.pyplot as plt

    def draw(file, column, label, variants):
        figure, axes = plt.subplots(figsize=(7, 4.2))
        for variant in variants:
            steps = [r for r in curves if r["variant"] == variant]
            axes.plot([int(r["vertices"]) for r in steps], [float(r[column]) for r in steps], label=variant, linewidth=1)
        axes.set(xscale="log", yscale="log", xlabel="vertices", ylabel=label)
        axes.legend()
        axes.grid(alpha=0.3)
        figure.tight_layout()
        figure.savefig(IMAGES / file, dpi=110)

    passes = ["sequential", "fractional 0.9", "fractional 0.5", "constant 20", "constant 5"]
    draw("insertion-rms.png", "rms", "RMS error", passes)
    draw("insertion-max.png", "largest", "maximum error", passes)
    draw("insertion-swaps.png", "rms", "RMS error", ["sequential", "data-dependent", "data-dependent, pure"])


def plot_times(times):
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(figsize=(7, 4.2))
    for variant in ["delaunay", "data-dependent"]:
        steps = [r for r in times[CRATER.stem] if r["variant"] == variant]
        axes.plot([float(r["seconds"]) for r in steps], [float(r["rms"]) for r in steps], "o-", label=variant)
        for r in steps:
            axes.annotate(r["vertices"], (float(r["seconds"]), float(r["rms"])), fontsize=7)
    axes.set(xscale="log", yscale="log", xlabel="seconds", ylabel="RMS error")
    axes.legend()
    axes.grid(alpha=0.3)
    figure.tight_layout()
    figure.savefig(IMAGES / "insertion-time.png", dpi=110)


if __name__ == "__main__":
    main()
