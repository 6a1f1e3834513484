"""Draws sets of terrain tiles in CesiumJS, in headless Chromium: every request is answered, nothing is said on the console, the
ground covers what it should, and heights that CesiumJS finds on it are those of the raster, within the level's error.

    scripts/cesium_tests.py            all of it, or the cases that are named; screenshots and a table in target/cesium
"""

import array
import json
import math
import os
import random
import shutil
import statistics
import subprocess
import sys
from pathlib import Path

from environment import node_modules_with

ROOT = Path(__file__).resolve().parent.parent
TARGET = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")).resolve()
TERRABITE = TARGET / os.environ.get("PROFILE", "release") / "terrabite"
# Of public terrains; cases without theirs are left out.
DATA = Path(os.environ.get("TERRABITE_DATA", ROOT.parent / "shared" / "data"))
OUT = TARGET / "cesium"
PACKAGES = ["playwright-core@1.65.1", "cesium@1.145.0"]
# Places where heights are compared: all over the raster, and in its middle, where its finest tiles are drawn.
PLACES, NEAR = 200, 200

HILLS = OUT / "hills.tif"
# Name, raster, largest error, other options.
CASES = [
    ("hills", HILLS, 1, []),
    ("hills-gzip", HILLS, 1, ["--gzip"]),
    ("hills-fine", HILLS, 1, ["--fine-heights"]),
    ("andes", DATA / "srtm3_S33W071.tif", 20, []),
    ("moon", DATA / "moon_tycho_4096.tif", 100, []),
]


def main():
    only = sys.argv[1:]
    browser = shutil.which("chromium")
    if browser is None:
        sys.exit("chromium is missing; scripts/setup_browser.sh installs it")
    modules = node_modules_with(PACKAGES, TARGET / "environments" / "cesium")
    OUT.mkdir(parents=True, exist_ok=True)
    run(TERRABITE, "synth", HILLS, "--size", "500x400", "--seed", "5", "--relief", "900", "--overwrite", "--quiet")
    place_hills()
    cases = []
    for name, raster, max_error, options in CASES:
        if only and name not in only:
            continue
        if not raster.exists():
            print(f"{name}: left out, {raster} is not there (TERRABITE_DATA names its folder)", file=sys.stderr)
            continue
        set_ = OUT / name
        run(TERRABITE, "tiles", raster, set_, "--max-error", max_error, *options, "--overwrite", "--quiet")
        cases.append(case(name, raster, set_))
    (OUT / "cases.json").write_text(json.dumps(cases))
    script = ROOT / "scripts" / "cesium.mjs"
    variables = {**os.environ, "NODE_MODULES": str(modules), "CHROMIUM": browser, "OUT": str(OUT)}
    sys.exit(subprocess.run(["node", script], env=variables).returncode)


def place_hills():
    """Puts the made terrain into the Alps, with cells of about 9 m: its finest tiles are small enough for 12 bits."""
    there = ["-a_srs", "EPSG:4326", "-a_ullr", "7.95", "46.04", "8", "46"]
    run("gdal_translate", "-q", *there, HILLS, HILLS.with_suffix(".placed.tif"))
    HILLS.with_suffix(".placed.tif").replace(HILLS)


def case(name, raster, folder):
    """What the browser is to find of a set: samples of the finest grid with their heights, by the definition in docs/tiles.md."""
    promise = json.loads((folder / "terrabite.json").read_text())
    info = json.loads(run("gdalinfo", "-json", raster))
    (width, height), (x0, dx, _, y0, _, dy) = info["size"], info["geoTransform"]
    missing = info["bands"][0].get("noDataValue")
    stored = OUT / "stored.bin"
    run("gdal_translate", "-q", "-of", "ENVI", "-ot", "Float64", raster, stored)
    heights = array.array("d", stored.read_bytes())
    cell = 180 / 2 ** promise["grid_exponent"]
    def place(lon, lat):
        """A sample of the grid near a place, with its height; None if it lies beyond the raster's samples or beside a missing one."""
        lon, lat = round((lon + 180) / cell) * cell - 180, 90 - round((90 - lat) / cell) * cell
        column, row = (lon - x0) / dx - 0.5, (lat - y0) / dy - 0.5
        c, r = math.floor(column), math.floor(row)
        if not (0 <= c < width - 1 and 0 <= r < height - 1):
            return None
        around = [heights[(r + j) * width + c + i] for j in (0, 1) for i in (0, 1)]
        p, q = column - c, row - r
        found = (1 - q) * ((1 - p) * around[0] + p * around[1]) + q * ((1 - p) * around[2] + p * around[3])
        return None if missing in around else [lon, lat, found]

    random.seed(1)
    middle = (x0 + dx * width / 2, y0 + dy * height / 2)
    everywhere = (dx * width / 2, dy * height / 2)
    # CesiumJS draws a level where its parent's error is more than two pixels. With 500 of them and a view of 1.15 × 0.77 of the
    # range, the finest tiles are drawn from this far.
    reach = 0.7 * promise["levels"][-2]["client_error"] * 500 / 2 / 0.77
    metres = math.radians(1) * promise["semi_minor"]
    around = (0.3 * reach / metres / math.cos(math.radians(middle[1])), 0.2 * reach / metres)
    places = []
    for (east, north), count in ((everywhere, PLACES), (around, PLACES + NEAR)):
        while len(places) < count:
            found = place(middle[0] + random.uniform(-1, 1) * east, middle[1] + random.uniform(-1, 1) * north)
            places += [found] if found else []
    near = {"first": PLACES, "range": reach, "pixel": reach * 1.15 / 750, "height": statistics.mean(place[2] for place in places[PLACES:])}
    bounds = [x0, y0 + dy * height, x0 + dx * width, y0]
    return {"name": name, "promise": promise, "places": places, "near": near, "bounds": bounds}


def run(*words):
    words = [str(word) for word in words]
    done = subprocess.run(words, capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"{' '.join(words)}: exit code {done.returncode}: {done.stderr}")
    return done.stdout


if __name__ == "__main__":
    main()
