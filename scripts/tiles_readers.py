"""Decodes sets of terrain tiles with decoders that others wrote for JavaScript, vertex by vertex. Called by `make test-readers`,
after the build; quantized-mesh-tile for Python is in `make test` (tests/it/tiles.py).

A set of a made terrain is decoded, and where there is one, a set of a real one. Exit code 1 where a decoder finds something else
than what the specification says is in the file.
"""

import os
import subprocess
import sys
from pathlib import Path

from environment import node_modules_with

ROOT = Path(__file__).resolve().parent.parent
TARGET = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")).resolve()
TERRABITE = Path(os.environ.get("TERRABITE") or TARGET / "release" / "terrabite").absolute()
DATA = Path(os.environ.get("TERRABITE_DATA", ROOT.parent / "shared" / "data"))
PACKAGES = ["@here/quantized-mesh-decoder@1.2.8", "@loaders.gl/core@4.5.4", "@loaders.gl/terrain@4.5.4"]
OUT = TARGET / "tiles-readers"


def main():
    modules = node_modules_with(PACKAGES, TARGET / "environments" / "tiles-readers")
    OUT.mkdir(parents=True, exist_ok=True)
    made = OUT / "made.tif"
    run(TERRABITE, "synth", made, "--size", "400x300", "--cell", "30", "--seed", "4", "--overwrite", "--quiet")
    rasters = [(made, 5), (DATA / "srtm3_S33W071.tif", 20)]
    for raster, max_error in rasters:
        if not raster.exists():
            print(f"tiles-readers: {raster} is not there; its part is skipped", file=sys.stderr)
            continue
        tiles = OUT / raster.stem
        run(TERRABITE, "tiles", raster, tiles, "--max-error", str(max_error), "--overwrite", "--quiet")
        run("node", ROOT / "scripts" / "tiles_readers.mjs", modules, tiles)


def run(*command):
    done = subprocess.run([str(part) for part in command])
    if done.returncode != 0:
        sys.exit(f"tiles-readers: {' '.join(str(part) for part in command)}: exit code {done.returncode}")


if __name__ == "__main__":
    main()
