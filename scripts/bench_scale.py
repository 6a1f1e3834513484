"""From 4096 × 4096 to 32768 × 32768 samples of one kind of terrain: does time grow as the raster does, and memory not
at all? Without polishing, and with the quality that is the default. Called by `make bench-scale`, after the build;
SIZES=4096,8192 chooses, and QUALITIES, ROUNDS, TOLERANCE, MEMORY, THREADS, PATIENCE.

The rasters are made by `terrabite synth` and kept; the largest takes about 4 GB, and as much again while it is decoded.
"""

import os
import statistics

from bench_common import (
    CPU, GDAL_FLOOR, MIB, PEAK, TERRABITE, WALL, WORK, best, grouped, interleaved, lists_option, machine, median, note,
    print_table, run, verify,
)

SIZES = [int(size) for size in os.environ.get("SIZES", "4096,8192,16384,32768").split(",")]
QUALITIES = os.environ.get("QUALITIES", "none,balanced").split(",")
ROUNDS = int(os.environ.get("ROUNDS", "3"))
TOLERANCE = os.environ.get("TOLERANCE", "8")
MEMORY = os.environ.get("MEMORY", "256MiB")
PATIENCE = float(os.environ.get("PATIENCE", "5"))
THREADS = int(os.environ.get("THREADS", "2"))

HEADER = [
    "raster", "quality", "threads", "max error", "triangles", "samples each", "wall s", "best s", "ms/Msample", "÷ first", "CPU ms/Msample",
    "÷ first", "peak MiB", "÷ first", "disk MiB", "time ÷ floor", "verify s", "verify MiB",
]


def main():
    WORK.mkdir(parents=True, exist_ok=True)
    header = machine()
    capped = lists_option("simplify", "--memory")
    rasters = {size: made(size) for size in SIZES}
    meshes = {quality: WORK / f"tin-{quality}.ply" for quality in QUALITIES}
    options = ["--max-error", TOLERANCE, "--threads", THREADS, "--overwrite", "--temp-dir", WORK, "--json"]
    options += ["--memory", MEMORY] if capped else []
    rows, first = [], {}

    def simplify(path, quality):
        return lambda: run(TERRABITE, "simplify", path, meshes[quality], "--quality", quality, *options)

    for size, path in rasters.items():
        note(f"{size} × {size}")
        programs = {"floor": lambda path=path: run(GDAL_FLOOR, "read", path, THREADS)}
        programs |= {quality: simplify(path, quality) for quality in QUALITIES}
        runs = interleaved(ROUNDS, PATIENCE, programs)
        for quality, mesh in meshes.items():
            check, verdict = verify(path, mesh, TOLERANCE)
            mesh.unlink()
            figures = Figures(size, quality, runs["floor"], runs[quality], check, verdict)
            rows.append(figures.row(first.setdefault(quality, figures)))
    print("\n".join(header))
    cap = f"--memory {MEMORY}" if capped else "no cap on memory"
    print(f"Tolerance {TOLERANCE}, up to {THREADS} threads, {cap}; {ROUNDS} runs of each, medians\n")
    print_table(HEADER, rows)


def made(size):
    """The raster of this size, made if it is not there yet."""
    path = WORK / f"synth-{size}.tif"
    if not path.exists():
        note(f"making {path.name}")
        run(TERRABITE, "synth", path, "--size", f"{size}x{size}", "--seed", 7, "--quiet")
    return path


class Figures:
    """What was measured at one size and quality."""

    def __init__(self, size, quality, floor, done, check, verdict):
        self.size, self.samples, self.quality = size, size * size, quality
        self.threads = done[-1].json()["memory"]["threads"]
        self.wall, self.cpu, self.peak = (median(done, what) for what in (WALL, CPU, PEAK))
        self.fastest = best(done)
        self.disk = statistics.median(r.json()["temporary_bytes"] for r in done)
        self.floor = median(floor, WALL)
        self.check, self.verdict = check, verdict

    def row(self, first):
        per = 1e9 / self.samples
        triangles, worst = self.verdict["triangles"], self.verdict["worst"]
        verdict = f"{worst['error']:.9g}" if worst else "none"
        growth = (self.wall / self.samples) / (first.wall / first.samples)
        cpu_growth = (self.cpu / self.samples) / (first.cpu / first.samples)
        return [
            f"{self.size}²", self.quality, str(self.threads), verdict if self.verdict["passed"] else f"{verdict} FAILED", grouped(triangles),
            f"{self.samples / triangles:.1f}", f"{self.wall:.2f}", self.fastest, f"{self.wall * per:.1f}",
            f"{growth:.2f}", f"{self.cpu * per:.1f}", f"{cpu_growth:.2f}", f"{self.peak / MIB:.0f}",
            f"{self.peak / first.peak:.2f}", f"{self.disk / MIB:.0f}", f"{self.wall / self.floor:.1f}",
            f"{self.check.wall:.1f}", f"{self.check.peak / MIB:.0f}",
        ]


if __name__ == "__main__":
    main()
