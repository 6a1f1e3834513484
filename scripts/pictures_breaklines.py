#!/usr/bin/env python3
"""Draws docs/images/breaklines-*.png: a road on a dam and a lake, without and with lines. Called by `make pictures`.

The ground is made up: hills, a road 7 m wide that a dam with slopes of 1 : 1.5 leads over them, and a basin with a lake. Cells are 2 m
wide, so the edges of the road lie between samples.
"""

import argparse
import json
import math
from pathlib import Path

from bench_common import ROOT, TERRABITE, WORK, run

IMAGES = ROOT / "docs" / "images"
COLUMNS, ROWS, CELL = 240, 160, 2.0
TOLERANCE = "1"
HALF_ROAD, SLOPE = 3.5, 1.5
LAKE, LEVEL = (130.0, 245.0), 54.0


def middle(t):
    """The middle of the road in metres from the upper left corner, by the share of its way."""
    return COLUMNS * CELL * (1.1 * t - 0.05), ROWS * CELL * (0.42 + 0.16 * math.sin(2.2 * math.pi * t))


MIDDLE = [middle(i / 400) for i in range(401)]


def ground(x, y):
    hills = 6 * math.sin(x / 70) * math.cos(y / 55) + 3 * math.sin((x + 2 * y) / 37)
    return 60 + hills - 12 * math.exp(-(((x - LAKE[0]) / 50) ** 2) - ((y - LAKE[1]) / 34) ** 2)


def height(x, y):
    off, at = min((math.hypot(x - a, y - b), i) for i, (a, b) in enumerate(MIDDLE))
    dam = 66 + 2 * math.sin(at / 130) - max(0.0, off - HALF_ROAD) / SLOPE
    return max(ground(x, y), dam)


def beside(off):
    """A line so far to the left of the middle of the road."""
    line = []
    for (a, b), (c, d) in zip(MIDDLE, MIDDLE[1:]):
        length = math.hypot(c - a, d - b)
        line.append((a - off * (d - b) / length, b + off * (c - a) / length))
    return line


def shore():
    """Where the ground rises to the lake's level, seen from the middle of the basin."""
    ring = []
    for i in range(120):
        along, down = math.cos(2 * math.pi * i / 120), math.sin(2 * math.pi * i / 120)
        reach = 1.0
        while ground(LAKE[0] + reach * along, LAKE[1] + reach * down) < LEVEL:
            reach += 0.25
        ring.append((LAKE[0] + reach * along, LAKE[1] + reach * down))
    return [*ring, ring[0]]


def write_raster(path):
    lines = [f"ncols {COLUMNS}", f"nrows {ROWS}", "xllcorner 0", f"yllcorner {-ROWS * CELL}", f"cellsize {CELL}"]
    for row in range(ROWS):
        heights = (height((column + 0.5) * CELL, (row + 0.5) * CELL) for column in range(COLUMNS))
        lines.append(" ".join(f"{h:.2f}" for h in heights))
    path.write_text("\n".join(lines) + "\n")


def write_layer(path, kind, shapes):
    features = []
    for shape in shapes:
        places = [[x, -y] for x, y in shape]
        geometry = {"type": kind, "coordinates": [places] if kind == "Polygon" else places}
        features.append({"type": "Feature", "properties": {}, "geometry": geometry})
    path.write_text(json.dumps({"type": "FeatureCollection", "features": features}))


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--into", type=Path, default=IMAGES, metavar="FOLDER", help="where the pictures go")
    into = parser.parse_args().into
    WORK.mkdir(parents=True, exist_ok=True)
    raster, roads, lakes = WORK / "dam.asc", WORK / "dam-roads.geojson", WORK / "dam-lakes.geojson"
    write_raster(raster)
    write_layer(roads, "LineString", [beside(HALF_ROAD), beside(-HALF_ROAD)])
    write_layer(lakes, "Polygon", [shore()])
    lines = ["--breaklines", roads, "--breakline-shift", "0.25", "--lake-polygons", lakes, "--lake-z", "min"]
    for name, options in ("without", ["--max-stray", "inf"]), ("with", lines):
        mesh, picture = WORK / "dam.ply", into / f"breaklines-{name}.png"
        report = run(TERRABITE, "simplify", raster, mesh, "--max-error", TOLERANCE, "--overwrite", "--json", *options).printed
        print(f"{name}: {json.loads(report)['triangles']} triangles")
        if options is lines:
            run(TERRABITE, "verify", raster, mesh, "--max-error", TOLERANCE, *options)
        run(TERRABITE, "preview", raster, mesh, picture, "--mode", "wireframe", "--size", "960x640", "--overwrite", "--quiet")


if __name__ == "__main__":
    main()
