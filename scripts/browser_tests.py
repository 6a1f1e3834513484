"""Opens pages of `verify --report`, `simplify --report` and `view` in headless Chromium: nothing is requested, nothing is said on the
console, figures are those of the JSON, charts, maps and the view are drawn, in light and dark and on paper. And makes the bundle of
viewer/ anew, which must be the one that is committed.

    scripts/browser_tests.py            all of it; screenshots in target/browser
"""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

from environment import node_modules_with

ROOT = Path(__file__).resolve().parent.parent
TARGET = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")).resolve()
# What drives the browser, from npm: without dependencies of its own.
PACKAGES = ["playwright-core@1.65.1"]
OUT = TARGET / "browser"


def main():
    browser = shutil.which("chromium")
    if browser is None:
        sys.exit("chromium is missing; scripts/setup_browser.sh installs it")
    modules = node_modules_with(PACKAGES, TARGET / "environments" / "browser")
    terrabite = TARGET / os.environ.get("PROFILE", "release") / "terrabite"
    OUT.mkdir(parents=True, exist_ok=True)
    pages = make_pages(terrabite)
    check_bundle()
    script = ROOT / "scripts" / "browser.mjs"
    variables = {**os.environ, "NODE_MODULES": str(modules), "CHROMIUM": browser, "OUT": str(OUT), "TERRABITE": str(terrabite)}
    done = subprocess.run(["node", script, *(str(page) for page in pages)], env=variables)
    sys.exit(done.returncode)


def check_bundle():
    """The program of the view, made from its sources with the packages that are locked: byte for byte what is committed."""
    folder = TARGET / "environments" / "viewer"
    shutil.rmtree(folder, ignore_errors=True)
    shutil.copytree(ROOT / "viewer", folder, ignore=shutil.ignore_patterns("node_modules", "dist"))
    for command in (["npm", "ci", "--ignore-scripts", "--no-audit", "--no-fund", "--silent"], ["node", "build.mjs"]):
        if subprocess.run(command, cwd=folder).returncode != 0:
            sys.exit(f"viewer: {' '.join(command)} fails (see above)")
    for name in ("view.js", "sums.txt"):
        if (folder / "dist" / name).read_bytes() != (ROOT / "viewer" / "dist" / name).read_bytes():
            sys.exit(f"viewer/dist/{name} is not what its sources make: make viewer")
    print("viewer: the bundle is what its sources make")


def make_pages(terrabite):
    """Pages of a mesh that passes, of one with three kinds of faults, of one that is too large for a page, and of the run."""
    def run(*words, code=0):
        found = subprocess.run([str(word) for word in (terrabite, *words)], capture_output=True, text=True)
        if found.returncode != code:
            sys.exit(f"{words}: expected exit code {code}, found {found.returncode}: {found.stderr}")

    dem, tin, bad = OUT / "dem.tif", OUT / "tin.ply", OUT / "bad.ply"
    made, passed, failed = OUT / "made.html", OUT / "passed.html", OUT / "failed.html"
    points = OUT / "gcp.csv"
    run("synth", dem, "--size", "600x400", "--seed", "5", "--nodata-share", "0.05", "--overwrite")
    run("simplify", dem, tin, "--max-error", "5", "--ascii", "--overwrite", "--quiet", "--report", made)
    lines = tin.read_text().splitlines()
    vertices = [line.split(" ") for line in lines[lines.index("end_header") + 1:][:200]]
    rows = [f"{x},{y},{float(z) + 0.1 * (i % 7 - 3)},{'NV'[i % 2]}" for i, (x, y, z) in enumerate(v[:3] for v in vertices)]
    points.write_text("x,y,z,cover\n" + "\n".join(rows) + "\n0,0,0,N\n")
    judge = ("verify", dem, "--max-error", "5", "--max-stray", "1.5", "--quiet", "--overwrite", "--report")
    run(*judge, passed, tin, "--checkpoints", points)
    (OUT / "tin.json").write_text(json.dumps(triangles_of(lines)))
    bad.write_text("\n".join(spoiled(lines)) + "\n")
    run(*judge, failed, bad, code=1)
    many, large = OUT / "many.tif", OUT / "large.html"
    run("synth", many, "--size", "1500x1000", "--seed", "7", "--overwrite")
    run("simplify", many, OUT / "many.ply", "--max-error", "0.3", "--quality", "fast", "--overwrite", "--quiet")
    run("verify", many, OUT / "many.ply", "--max-error", "0.3", "--quiet", "--overwrite", "--report", large)
    return [passed, failed, large, made]


def triangles_of(lines):
    """Vertices and triangles of a mesh in text."""
    numbers = [line.split(" ") for line in lines[lines.index("end_header") + 1:]]
    count = int(next(line for line in lines if line.startswith("element vertex")).split(" ")[2])
    vertices = [[float(number) for number in vertex[:3]] for vertex in numbers[:count]]
    return {"vertices": vertices, "triangles": [[int(vertex) for vertex in face[1:4]] for face in numbers[count:]]}


def spoiled(lines):
    """The mesh with a vertex 40 too high, three faces left out, and one turned over."""
    begin = lines.index("end_header") + 1
    count = int(next(line for line in lines if line.startswith("element vertex")).split(" ")[2])
    lines, middle = list(lines), begin + count
    x, y, z = lines[begin + count // 2].split(" ")[:3]
    lines[begin + count // 2] = f"{x} {y} {float(z) + 40}"
    number, a, b, c = lines[middle + 50].split(" ")[:4]
    lines[middle + 50] = f"{number} {a} {c} {b}"
    faces = len(lines) - middle
    del lines[middle + faces // 2:middle + faces // 2 + 3]
    return [f"element face {faces - 3}" if line.startswith("element face") else line for line in lines]


if __name__ == "__main__":
    main()
