#!/usr/bin/env python3
"""Draws docs/images/looks-*.png, the pictures of docs/quality.md, "Looks". Called by `make pictures`.

Meshes of the default quality by two builds of terrabite, `before` and `after`, shaded by this build's `preview` with the
same vertical scale: of every scene a place at a tile line, and one at the raster's rim. Prints what `preview` says.
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
SIZE = "600x400"
LARGEST = 250_000


@dataclass
class Crop:
    name: str
    # Column and row of the upper left sample.
    corner: tuple
    # Cells across and down.
    cells: tuple


def at_lines(*corner):
    return Crop("lines", corner, (300, 200))


def at_rim(*corner):
    return Crop("rim", corner, (120, 80))


@dataclass
class Scene:
    name: str
    raster: Path
    tolerance: str
    # What `preview` chooses for the whole raster.
    vertical_scale: str
    crops: list


# The crops are where `before` has most dark dashes.
SCENES = [
    Scene("tycho", DATA / "moon_tycho_4096.tif", "100", "1.9", [at_lines(80, 2460), at_rim(0, 2725)]),
    Scene("england", DATA / "srtm3_mosaic_n_england.tif", "20", "3.7", [at_lines(1780, 1860), at_rim(3480, 2310)]),
    # The terrain of scripts/demo.sh.
    Scene("demo", TARGET / "demo" / "dem.tif", "5", "1.1", [at_lines(860, 640), at_rim(0, 1490)]),
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
    mesh = WORK / "pictures.ply"
    run(build, "simplify", scene.raster, mesh, "--max-error", scene.tolerance, "--overwrite", "--quiet")
    for crop in scene.crops:
        picture = folder / f"looks-{scene.name}-{crop.name}-{half}.png"
        window = ",".join(str(n) for n in (*crop.corner, *(cells + 1 for cells in crop.cells)))
        said = run(
            TERRABITE, "preview", scene.raster, mesh, picture, "--window", window, "--size", SIZE, "--vertical-exaggeration",
            scene.vertical_scale, "--overwrite",
        )
        print(said.printed, end="")
        if picture.stat().st_size > LARGEST:
            sys.exit(f"pictures: {picture} has {picture.stat().st_size} bytes, more than {LARGEST}")
    mesh.unlink()


if __name__ == "__main__":
    main()
