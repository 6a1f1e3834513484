"""terrabite against pydelatin and against GDAL alone, in one table. Called by `make bench`, after the build.

Every raster is simplified by each program at the same tolerance, several times in turn; medians are printed. Both
meshes are judged by `terrabite verify`. See docs/BENCHMARKS.md for what the columns mean.
"""

import argparse
import os
import statistics
from dataclasses import dataclass
from pathlib import Path

from bench_common import (
    CPU, GDAL_FLOOR, MIB, PEAK, ROOT, TERRABITE, WALL, WORK, best, grouped, interleaved, machine, median, note,
    print_table, run, simplify, verify,
)
from environment import python_with

DATA = Path(os.environ.get("TERRABITE_DATA", ROOT / ".." / "shared" / "data"))
CASES = [
    ("moon_tycho_4096", "20"),
    ("moon_tycho_4096", "200"),
    ("moon_highlands_8192", "20"),
    ("srtm3_mosaic_n_england", "5"),
]
# Where there are no real terrains: side, seed and tolerances.
MADE = [(4096, 7, ["2", "10"])]

# The engines alone.
VARIANTS = {
    "plain cuts": ["--quality", "none", "--cuts", "plain"],
    "insertion": ["--quality", "none", "--engine", "greedy-insertion"],
}

HEADER = [
    "raster, tolerance", "program", "triangles", "max error", "wall s", "best s", "CPU s", "Msamples/s", "peak MiB",
    "triangles ÷ peer", "speed ÷ peer", "speed ÷ its process", "CPU time ÷ peer", "memory ÷ peer", "time ÷ floor",
]


@dataclass
class Raster:
    name: str
    path: Path
    width: int
    height: int
    geotransform: list

    @property
    def samples(self):
        return self.width * self.height

    @property
    def raw(self):
        """The bare heights for pydelatin, made when they are asked for first."""
        raw = WORK / f"{self.name}.f32"
        if not raw.exists() or raw.stat().st_size != 4 * self.samples:
            run(GDAL_FLOOR, "raw", self.path, raw)
        return raw


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rounds", type=int, default=3, help="runs of every program")
    parser.add_argument("--threads", type=int, default=2, choices=range(2, 65), metavar="2..64", help="threads of the parallel runs")
    parser.add_argument("--only", default="", help="only rasters whose name contains this")
    parser.add_argument("--patience", type=float, default=5, help="seconds to wait for idle cores before a run")
    arguments = parser.parse_args()
    WORK.mkdir(parents=True, exist_ok=True)
    python = environment()
    header = machine()
    rows = []
    for name, path, tolerance in cases():
        if arguments.only in name:
            rows += compare(described(name, path), tolerance, python, arguments)
    print("\n".join(header))
    print(f"Peer: {peer(python)}; {arguments.rounds} runs of each in turn, medians\n")
    print_table(HEADER, rows)
    if any("over" in row[3] for row in rows):
        print("\n'over': the mesh is above the tolerance somewhere, or is not one surface.")


def cases():
    found = [(name, DATA / f"{name}.tif", t) for name, t in CASES if (DATA / f"{name}.tif").exists()]
    if found:
        return found
    note(f"no real terrains in {DATA} (set TERRABITE_DATA): making some")
    made = []
    for side, seed, tolerances in MADE:
        path = WORK / f"synth-{side}-seed{seed}.tif"
        if not path.exists():
            run(TERRABITE, "synth", path, "--size", f"{side}x{side}", "--seed", seed, "--quiet")
        made += [(path.stem, path, t) for t in tolerances]
    return made


def described(name, path):
    told = run(TERRABITE, "info", path, "--json").json()
    return Raster(name, path, told["width"], told["height"], told["geotransform"])


def compare(raster, tolerance, python, arguments):
    """The rows of one raster at one tolerance."""
    note(f"{raster.name} at {tolerance}")
    mesh, many = WORK / "tin.ply", arguments.threads
    child = [python, Path(__file__).with_name("bench_pydelatin.py"), raster.raw, raster.width, raster.height, tolerance]

    def terrabite(threads, options):
        return simplify(TERRABITE, raster.path, mesh, tolerance, threads, options)

    programs, ours = {}, {}
    for name, options in VARIANTS.items():
        for count in [many, 1]:
            programs[f"{name} {count}"] = lambda count=count, options=options: terrabite(count, options)
    for count in [many, 1]:
        programs[f"floor {count}"] = lambda count=count: run(GDAL_FLOOR, "read", raster.path, count)
    programs["pydelatin"] = lambda: run(*child)
    runs = interleaved(arguments.rounds, arguments.patience, programs)
    for name, options in VARIANTS.items():
        terrabite(many, options)
        ours[name] = verify(raster.path, mesh, tolerance)[1]
    run(*child, "--ply", mesh, "--geotransform", *raster.geotransform)
    theirs = verify(raster.path, mesh, tolerance)[1]
    mesh.unlink()
    return table(raster, tolerance, many, runs, ours, theirs)


def table(raster, tolerance, many, runs, ours, theirs):
    """Ratios are to pydelatin's triangulation alone, to its whole process, and to GDAL on as many threads."""
    peer = runs["pydelatin"]
    steps = [r.json() for r in peer]
    alone = statistics.median(s["triangulate_seconds"] for s in steps)
    alone_cpu = statistics.median(s["triangulate_cpu_seconds"] for s in steps)
    loading = statistics.median(s["load_seconds"] for s in steps)
    peer_wall, peer_cpu, peer_peak = (median(peer, what) for what in (WALL, CPU, PEAK))

    def row(program, mesh, wall, fastest="", cpu=None, peak=None, ratios=()):
        count, error = (grouped(mesh["triangles"]), judged(mesh)) if mesh else ("", "")
        cells = [
            f"{raster.name}, {tolerance}", program, count, error, f"{wall:.2f}", fastest,
            "" if cpu is None else f"{cpu:.2f}", f"{raster.samples / wall / 1e6:.1f}",
            "" if peak is None else f"{peak / MIB:.0f}", *ratios,
        ]
        return cells + [""] * (len(HEADER) - len(cells))

    def threads(count):
        return f"{count} thread{'s' * (count > 1)}"

    rows = []
    for name, count in [(name, count) for name in VARIANTS for count in [many, 1]]:
        done, floor = runs[f"{name} {count}"], median(runs[f"floor {count}"], WALL)
        wall, cpu, peak = (median(done, what) for what in (WALL, CPU, PEAK))
        triangles = ours[name]["triangles"] / theirs["triangles"]
        ratios = [triangles, alone / wall, peer_wall / wall, cpu / alone_cpu, peak / peer_peak, wall / floor]
        ratios = [f"{r:.2f}" for r in ratios]
        rows.append(row(f"{name}, {threads(count)}", ours[name], wall, best(done), cpu, peak, ratios))
    fastest = f"{min(s['triangulate_seconds'] for s in steps):.2f}"
    rows.append(row("pydelatin, triangulation", theirs, alone, fastest, alone_cpu, peer_peak))
    rows.append(row("pydelatin, whole process", theirs, peer_wall, best(peer), peer_cpu, peer_peak))
    rows.append(row("pydelatin, loading", None, loading))
    for count in [many, 1]:
        done = runs[f"floor {count}"]
        wall, cpu, peak = (median(done, what) for what in (WALL, CPU, PEAK))
        rows.append(row(f"GDAL alone, {threads(count)}", None, wall, best(done), cpu, peak))
    return rows


def judged(verdict):
    worst = verdict["worst"]
    error = "none" if worst is None else f"{worst['error']:.9g}"
    return error if verdict["passed"] else f"{error} over"


def environment():
    """A virtual environment with the pinned peer; its Python."""
    return python_with(Path(__file__).with_name("bench-requirements.txt"), WORK / "venv")


def peer(python):
    code = (
        "from importlib.metadata import version as v; import platform; "
        "print(f\"pydelatin {v('pydelatin')}, numpy {v('numpy')}, Python {platform.python_version()}\")"
    )
    return run(python, "-c", code).printed.strip()


if __name__ == "__main__":
    main()
