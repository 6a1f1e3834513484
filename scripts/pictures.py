#!/usr/bin/env python3
"""Draws docs/images/looks-*.png, the pictures of docs/quality.md, "Looks". Called by `make pictures`.

Three meshes of the default quality by two builds of terrabite, `before` and `after`, shaded by this build's `preview` with
the same vertical scale. Each picture has the raster's rim and a tile line, 4 pixels a cell. Prints what `preview` says.
"""

import argparse
import shutil
import sys
from dataclasses import dataclass
from pathlib import Path

import bench_against
from bench import DATA
from bench_common import ROOT, TARGET, TERRABITE, WORK, run

IMAGES = ROOT / "docs" / "images"
# The last commit whose second pass left vertices where its lines cross seams, and the rim as it was cut.
BEFORE = "1db5b0f"
CELLS = (150, 100)
PIXELS_PER_CELL = 4
LARGEST = 250_000


@dataclass
class Scene:
    name: str
    raster: Path
    tolerance: str
    # Column and row of the upper left sample.
    corner: tuple


SCENES = [
    Scene("tycho", DATA / "moon_tycho_4096.tif", "100", (950, 0)),
    Scene("england", DATA / "srtm3_mosaic_n_england.tif", "20", (950, 0)),
    # The terrain of scripts/demo.sh.
    Scene("demo", TARGET / "demo" / "dem.tif", "5", (950, 0)),
]
DEMO = ["--size", "2048x2048", "--seed", "7"]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--before", default=BEFORE, metavar="REV|PROGRAM", help=f"the other build [default: {BEFORE}]")
    parser.add_argument("--only", choices=["before", "after"], help="only the pictures of one build")
    parser.add_argument("--into", type=Path, default=IMAGES, metavar="FOLDER", help="where the pictures go")
    arguments = parser.parse_args()
    WORK.mkdir(parents=True, exist_ok=True)
    make_demo()
    missing = [str(scene.raster) for scene in SCENES if not scene.raster.is_file()]
    if missing:
        sys.exit(f"pictures: not there: {', '.join(missing)} (set TERRABITE_DATA)")
    programs = {"before": lambda: program(arguments.before), "after": lambda: TERRABITE}
    for half, found in programs.items():
        if arguments.only in (None, half):
            for scene in SCENES:
                draw(scene, half, found(), arguments.into)


def program(before):
    """The other build: a program, or a commit that is built first."""
    path = shutil.which(before) if "/" in before else None
    return Path(path) if path else bench_against.Build(before).program


def make_demo():
    demo = TARGET / "demo" / "dem.tif"
    demo.parent.mkdir(parents=True, exist_ok=True)
    run(TERRABITE, "synth", demo, *DEMO, "--overwrite", "--quiet")


def draw(scene, half, build, folder):
    mesh, picture = WORK / "pictures.ply", folder / f"looks-{scene.name}-{half}.png"
    run(build, "simplify", scene.raster, mesh, "--max-error", scene.tolerance, "--overwrite", "--quiet")
    window = ",".join(str(n) for n in (*scene.corner, *(cells + 1 for cells in CELLS)))
    size = "x".join(str(cells * PIXELS_PER_CELL) for cells in CELLS)
    said = run(TERRABITE, "preview", scene.raster, mesh, picture, "--window", window, "--size", size, "--overwrite")
    print(said.printed, end="")
    if picture.stat().st_size > LARGEST:
        sys.exit(f"pictures: {picture} has {picture.stat().st_size} bytes, more than {LARGEST}")


if __name__ == "__main__":
    main()
