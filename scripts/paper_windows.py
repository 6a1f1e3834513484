#!/usr/bin/env python3
"""Repeats table 1 of Silva, Mitchell & Kaufman 1995 and of Agarwal & Desikan 1997 on windows of rasters, puts tables into
docs/hitting-set.md and plots beside it.

Runs examples/silva_agarwal, one process for every window and method. The rasters are those of the data folder
(TERRABITE_DATA, else ../shared/data) that miss no sample; of the two of the Moon the smaller one.
"""

import math
import sys

from paper_common import DATA, IMAGES, ROOT, experiment, fill, grouped, reexec_with_matplotlib, table

PAGE = ROOT / "docs" / "hitting-set.md"
RASTERS = [
    "crater_lake_garland",
    "lidar_wetland_1m",
    "mars_mola_4ppd",
    "moon_tycho_4096",
    "srtm3_N57E011",
    "srtm3_S33W071",
    "srtm3_mosaic_n_england",
]
FRANKLIN = "franklin-delaunay"
# What tables call the methods, in the order of the columns.
NAMES = {
    FRANKLIN: "Franklin, Delaunay",
    "franklin-error": "Franklin, largest error",
    "cuts-weak": "cuts, weak",
    "cuts-strong": "cuts, strong",
    "improved-weak": "improved cuts, weak",
    "improved-strong": "improved cuts, strong",
    "insertion": "insertion",
    "sp-a": "SP-A, nested squares",
    "sp-a-sliding": "SP-A, sliding squares",
    "sp-b": "SP-B, nested squares",
    "sp-b-sliding": "SP-B, sliding squares",
    "stitched-disjoint": "stitched, squares apart",
    "stitched-shared": "stitched, shared corners",
    "hitting-set": "hitting set",
    "cuts-polished": "cuts, balanced",
    "insertion-polished": "insertion, balanced",
    "hitting-set-polished": "hitting set, balanced",
}
# Triangles of the papers' tables: Franklin, cuts weak, cuts strong (1995), SP-A, SP-B, stitched (1997).
PAPERS = {
    "Buffalo": (1994, 1641, 2279, 964, 1399, 2125),
    "Denver": (2688, 2137, 2849, 1163, 2049, 2527),
    "Eagle Pass": (1564, 1214, 1578, 596, 1332, 1274),
    "Grand Canyon": (2822, 2073, 3115, 1167, 1928, 2725),
    "Jackson": (1297, 859, 1127, 453, 1150, 1047),
    "Moab": (2561, 1836, 2430, 926, 1827, 1879),
    "Seattle": (2671, 2011, 2763, 973, 1948, 2259),
}
# Which of their columns a method is held against.
COLUMNS = {
    "cuts-weak": 1,
    "cuts-strong": 2,
    "sp-a": 3,
    "sp-a-sliding": 3,
    "sp-b": 4,
    "sp-b-sliding": 4,
    "stitched-disjoint": 5,
    "stitched-shared": 5,
}


def main():
    missing = [str(DATA / f"{r}.tif") for r in RASTERS if not (DATA / f"{r}.tif").exists()]
    if missing:
        sys.exit(f"paper: not there: {', '.join(missing)} (set TERRABITE_DATA)")
    reexec_with_matplotlib(__file__)
    methods = [row["method"] for row in experiment("silva_agarwal", "methods")]
    if methods != list(NAMES):
        sys.exit(f"paper: NAMES has other methods than the program: {methods}")
    windows = {raster: experiment("silva_agarwal", "window", path(raster))[0] for raster in RASTERS}
    runs = {
        raster: {m: experiment("silva_agarwal", "run", m, path(raster), w["tolerance"])[0] for m in methods}
        for raster, w in windows.items()
    }
    readings = {raster: experiment("silva_agarwal", "readings", path(raster), w["tolerance"]) for raster, w in windows.items()}
    bounds = {raster: experiment("silva_agarwal", "bound", path(raster), w["tolerance"])[0] for raster, w in windows.items()}
    ratios = {m: [triangles(run, m) / triangles(run, FRANKLIN) for run in runs.values()] for m in methods}
    fill(
        PAGE,
        {
            "windows": windows_table(windows),
            "triangles": triangles_table(runs, ratios),
            "ratios": ratios_table(ratios),
            "readings": readings_table(readings, runs),
            "goals": goals_table(runs),
            "times": times_table(runs),
            "bounds": bounds_table(bounds, runs),
        },
    )
    plot(ratios)


def path(raster):
    return DATA / f"{raster}.tif"


def triangles(run, method):
    return int(run[method]["triangles"])


def mean(numbers):
    return math.exp(sum(map(math.log, numbers)) / len(numbers))


def papers(method):
    """The papers' ratios to Franklin; none where they do not have the method."""
    column = COLUMNS.get(method)
    return [] if column is None else [row[column] / row[0] for row in PAPERS.values()]


def windows_table(windows):
    def row(raster, w):
        return [raster, w["stride"], f"{w['column']}, {w['row']}", f"{number(w['low'])} to {number(w['high'])}", number(w["tolerance"])]

    header = ["raster", "every n-th sample", "first column, row", "heights", "ε"]
    return table(header, [row(raster, w) for raster, w in windows.items()])


def number(text):
    return f"{float(text):.5g}"


def triangles_table(runs, ratios):
    rows = [[NAMES[m], *(grouped(triangles(run, m)) for run in runs.values()), f"{mean(r):.2f}"] for m, r in ratios.items()]
    return table(["triangles", *runs, "of Franklin"], rows)


def between(ratios):
    return f"{min(ratios):.2f} to {max(ratios):.2f}, mean {mean(ratios):.2f}" if ratios else ""


def ratios_table(ratios):
    by_error = ratios["franklin-error"]
    rows = [
        [NAMES[m], between(papers(m)), between(r), between([a / b for a, b in zip(r, by_error)])]
        for m, r in ratios.items()
        if m != FRANKLIN
    ]
    return table(["triangles to Franklin's", "the papers' terrains", "here, to Delaunay", "here, to largest error"], rows)


def readings_table(readings, runs):
    def row(raster, reading):
        return [
            raster,
            reading["reading"],
            grouped(int(reading["before"])),
            grouped(int(reading["failing"])),
            grouped(int(reading["triangles"])),
            f"{int(reading['before']) / triangles(runs[raster], 'sp-a'):.2f}",
        ]

    header = ["raster", "squares", "triangles", "not within ε", "repaired", "triangles to SP-A's"]
    return table(header, [row(raster, r) for raster, both in readings.items() for r in both])


def goals_table(runs):
    against = [
        ("hitting-set", FRANKLIN),
        ("hitting-set", "stitched-disjoint"),
        ("hitting-set", "stitched-shared"),
        ("hitting-set-polished", "insertion-polished"),
    ]

    def row(method, other):
        ratios = [triangles(run, method) / triangles(run, other) for run in runs.values()]
        return [f"{NAMES[method]} ÷ {NAMES[other]}", *(f"{r:.2f}" for r in ratios), f"{mean(ratios):.3f}"]

    return table(["ratio of triangles", *runs, "mean"], [row(*pair) for pair in against])


def bounds_table(bounds, runs):
    def row(raster, bound):
        best = min(runs[raster], key=lambda m: triangles(runs[raster], m) if not m.startswith("sp-") else math.inf)
        fewest = triangles(runs[raster], best)
        shares = [f"{int(bound[b])} ({100 * int(bound[b]) / fewest:.1f} %)" for b in ("incompatible", "weights")]
        return [raster, *shares, f"{grouped(fewest)} ({NAMES[best]})"]

    header = ["raster", "incompatible samples", "weights", "the fewest triangles of a mesh here"]
    return table(header, [row(*item) for item in bounds.items()])


def times_table(runs):
    def cell(run, method):
        return f"{1e3 * float(run[method]['seconds']):.1f}, {grouped(int(run[method]['kib']))}"

    rows = [[NAMES[m], *(cell(run, m) for run in runs.values())] for m in NAMES]
    return table(["ms, KiB", *runs], rows)


def plot(ratios):
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(figsize=(8, 4.6))
    shown = [m for m in ratios if m != FRANKLIN]
    for line, method in enumerate(reversed(shown)):
        theirs = papers(method)
        axes.plot(theirs, [line + 0.15] * len(theirs), "s", color="tab:orange", markersize=4)
        axes.plot(ratios[method], [line - 0.1] * len(ratios[method]), "o", color="tab:blue", markersize=4)
    axes.set_yticks(range(len(shown)), [NAMES[m] for m in reversed(shown)])
    axes.axvline(1, color="grey", linewidth=0.8)
    axes.set(xlabel="triangles, as a share of Franklin's (Delaunay)")
    axes.plot([], [], "s", color="tab:orange", markersize=4, label="the papers' terrains")
    axes.plot([], [], "o", color="tab:blue", markersize=4, label="these windows")
    axes.legend()
    axes.grid(alpha=0.3, axis="x")
    figure.tight_layout()
    figure.savefig(IMAGES / "windows-ratios.png", dpi=110)


if __name__ == "__main__":
    main()
