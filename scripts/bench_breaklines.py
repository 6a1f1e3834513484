"""What lines cost: triangles and time with random lines and with contours, by engine and quality, and `terrabite verify` on each mesh.

    python3 scripts/bench_breaklines.py                           the cases of docs/breaklines.md
    python3 scripts/bench_breaklines.py DEM.tif 5 --lines 50,1000 another raster, at this tolerance

Lines are walks of `--vertices` steps, each a few cells long, from a seed: the same raster gives the same lines. Contours are
gdal_contour's. Needs gdalinfo and gdal_contour (gdal-bin in Debian) and `cargo build --release`.
"""

import argparse
import json
import math
import random
import subprocess
import sys
from pathlib import Path

from bench import DATA
from bench_common import MIB, TERRABITE, WORK, grouped, machine, note, print_table, run, settle

ENGINES = {"insertion": ["--engine", "greedy-insertion"], "cuts": ["--engine", "greedy-cuts"]}
# Raster, tolerance, numbers of lines, metres between contours.
CASES = [("pataha_10m", "2", [50, 1000], 20), ("srtm3_N46E008", "20", [50, 5000], 250), ("moon_tycho_4096", "20", [1000], 500)]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("raster", nargs="?", help="a raster, instead of the usual cases")
    parser.add_argument("tolerance", nargs="?", help="the tolerance for it")
    parser.add_argument("--lines", default="50,1000", help="numbers of lines over it")
    parser.add_argument("--contours", type=float, default=0, help="and contours of so many units of height")
    parser.add_argument("--vertices", type=int, default=60)
    parser.add_argument("--engines", default="insertion,cuts")
    parser.add_argument("--qualities", default="none,fast,balanced")
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--patience", type=float, default=5, help="seconds to wait for idle cores before a run")
    arguments = parser.parse_args()
    WORK.mkdir(parents=True, exist_ok=True)
    cases = CASES
    if arguments.raster:
        numbers = [int(number) for number in arguments.lines.split(",") if number]
        cases = [(arguments.raster, arguments.tolerance, numbers, arguments.contours)]
    print("\n".join(machine()) + "\n")
    rows = []
    for name, tolerance, numbers, interval in cases:
        raster = Path(name) if Path(name).exists() else DATA / f"{name}.tif"
        if not raster.exists():
            sys.exit(f"bench: {raster} is missing")
        layers = [None] + [walks(raster, number, arguments.vertices) for number in numbers]
        layers += [contours(raster, interval)] if interval else []
        for quality in arguments.qualities.split(","):
            for engine in arguments.engines.split(","):
                rows += [row(raster, tolerance, layer, quality, engine, arguments) for layer in layers]
    print_table(
        ["raster, ε", "quality", "engine", "lines", "segments", "edges", "triangles", "CPU s", "MiB", "verify CPU s"], rows
    )


def walks(raster, number, vertices):
    """A layer of random walks over a raster, in its CRS."""
    about = json.loads(subprocess.run(["gdalinfo", "-json", raster], capture_output=True, check=True, text=True).stdout)
    (width, height), (x, dx, _, y, _, dy) = about["size"], about["geoTransform"]
    chance = random.Random(f"{width}x{height} {number}")
    features = []
    for _ in range(number):
        column, row, heading = chance.uniform(0, width), chance.uniform(0, height), chance.uniform(0, 2 * math.pi)
        line = []
        for _ in range(vertices):
            line.append([x + column * dx, y + row * dy])
            heading += chance.gauss(0, 0.3)
            step = chance.uniform(1, 5)
            column, row = column + step * math.cos(heading), row + step * math.sin(heading)
        features.append({"type": "Feature", "properties": {}, "geometry": {"type": "LineString", "coordinates": line}})
    wkt = about.get("coordinateSystem", {}).get("wkt", "")
    layer = WORK / f"lines-{raster.stem}-{number}.gpkg"
    plain = WORK / f"lines-{raster.stem}-{number}.geojson"
    plain.write_text(json.dumps({"type": "FeatureCollection", "features": features}))
    as_it_is = ["-a_srs", wkt] if wkt else []
    subprocess.run(["ogr2ogr", "-overwrite", *as_it_is, layer, plain], check=True)
    return layer


def contours(raster, interval):
    """A layer of the raster's contours."""
    layer = WORK / f"contours-{raster.stem}-{interval:g}.gpkg"
    layer.unlink(missing_ok=True)
    subprocess.run(["gdal_contour", "-q", "-i", str(interval), raster, layer], check=True)
    return layer


def row(raster, tolerance, layer, quality, engine, arguments):
    note(f"{raster.stem} {quality} {engine} {layer.stem if layer else 'no lines'}")
    settle(arguments.patience)
    mesh = WORK / "breaklines.ply"
    lines = ["--breaklines", layer] if layer else []
    made = run(
        TERRABITE, "simplify", raster, mesh, "--max-error", tolerance, "--quality", quality, "--threads", arguments.threads,
        "--overwrite", "--json", *ENGINES[engine], *lines,
    )
    judged = run(TERRABITE, "verify", raster, mesh, "--max-error", tolerance, "--threads", arguments.threads, "--json", *lines)
    report, of_lines = made.json(), (made.json().get("breaklines") or {})
    assert judged.json()["passed"]
    return [
        f"{raster.stem}, {tolerance}", quality, engine, grouped(of_lines["lines"]) if layer else "–",
        grouped(of_lines["segments"]) if layer else "", grouped(of_lines["chains"]["edges"]) if layer else "",
        grouped(report["triangles"]), f"{made.cpu:.1f}", f"{made.peak / MIB:.0f}", f"{judged.cpu:.1f}",
    ]


if __name__ == "__main__":
    main()
