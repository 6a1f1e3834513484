"""What terrain tiles are like, level by level: errors, gaps, triangles, bytes and time, and `terrabite tiles-verify` on each set.

    python3 scripts/bench_tiles.py                        the rasters of docs/tiles.md
    python3 scripts/bench_tiles.py DEM.tif 20             another raster, at this --max-error
    python3 scripts/bench_tiles.py --options=--own-samples

Each set is made twice, plain and with --gzip. Seconds are processor time: those of a level are its share, by the clock, of those of the whole
run. Needs `cargo build --release`.
"""

import argparse
import shlex
import shutil
import sys
from pathlib import Path

from bench import DATA
from bench_common import MIB, TERRABITE, WORK, machine, note, print_table, run, settle

CASES = [
    ("srtm3_N46E008", "20"), ("srtm3_S33W071", "20"), ("srtm3_mosaic_n_england", "20"), ("sainte_helens", "10"), ("moon_tycho_4096", "20"),
]
HEADER = [
    "level", "allowed, m", "largest, m", "at own samples, m", "beyond", "largest gap to a coarser level, m", "tiles", "triangles", "kB",
    "gzip, kB", "CPU, s",
]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("raster", nargs="?", help="a raster, instead of the usual ones")
    parser.add_argument("error", nargs="?", default="20", help="the largest error of its finest level, in metres")
    parser.add_argument("--options", default="", help="further options of tiles")
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--patience", type=float, default=5, help="seconds to wait for idle cores before a run")
    arguments = parser.parse_args()
    WORK.mkdir(parents=True, exist_ok=True)
    print("\n".join(machine()))
    failed = []
    for name, error in [(arguments.raster, arguments.error)] if arguments.raster else CASES:
        raster = Path(name) if Path(name).exists() else DATA / f"{name}.tif"
        if not raster.exists():
            note(f"{raster} is missing: left out")
            continue
        if not tell(raster, error, arguments):
            failed.append(raster.stem)
    if failed:
        sys.exit(f"bench: not passed: {', '.join(failed)}")


def tell(raster, error, arguments):
    """Prints the table of a raster; says whether both sets keep their promises."""
    options = shlex.split(arguments.options)
    plain, judged = made_and_judged(raster, error, options, arguments)
    gzip, judged_gzip = made_and_judged(raster, error, [*options, "--gzip"], arguments)
    report, verdict = plain.json(), judged.json()
    passed = verdict["passed"] and judged_gzip.json()["passed"]
    print(f"\n**{raster.stem}**, `{' '.join(['--max-error', error, *options])}`: {'passed' if passed else 'NOT passed'}; ", end="")
    total = [sum(level[key] for level in run["levels"]) for run in (report, gzip.json()) for key in ("tiles", "triangles", "bytes_in_files")]
    print(f"{count(total[0])} tiles, {count(total[1])} triangles, {count(total[2])} bytes, {count(total[5])} with `--gzip`. ", end="")
    grid = plain.cpu * report["seconds_resampling"] / report["seconds"]
    print(f"CPU of `tiles` {plain.cpu:.1f} s, {grid:.1f} of them for the grid, with `--gzip` {gzip.cpu:.1f} s, of `tiles-verify` {judged.cpu:.1f} s; ", end="")
    print(f"memory {plain.peak / MIB:.0f} and {judged.peak / MIB:.0f} MiB.\n")
    print_table(HEADER, [row(level, report, gzip.json(), verdict, plain.cpu) for level in range(len(report["levels"]))])
    return passed


def made_and_judged(raster, error, options, arguments):
    note(" ".join([raster.stem, *options]))
    folder = WORK / "tiles"
    shutil.rmtree(folder, ignore_errors=True)
    settle(arguments.patience)
    common = ["--threads", arguments.threads, "--temp-dir", WORK, "--json"]
    made = run(TERRABITE, "tiles", raster, folder, "--max-error", error, *options, *common)
    judged = run(TERRABITE, "tiles-verify", raster, folder, *common, may_fail=True)
    shutil.rmtree(folder)
    if not judged.printed.startswith("{"):
        sys.exit(f"bench: cannot verify tiles of {raster}: {judged.printed}")
    return made, judged


def row(level, report, gzip, verdict, cpu):
    made, found = report["levels"][level], verdict["levels"][level]
    own, seconds = found["own_samples"], cpu * made["seconds"] / report["seconds"]
    gaps = [gap for gap in verdict["gaps"] if gap["finer"] == level and gap["largest"] > 0]
    gap = max(gaps, key=lambda gap: gap["largest"] / gap["allowed"], default=None)
    return [
        str(level), number(made["max_error"]), number(found["largest_error"]), number(own["largest_error"]), f"{100 * own['share_above']:.3f} %",
        f"{number(gap['largest'])} of {number(gap['allowed'])} to {gap['coarser']}" if gap else "–", count(made["tiles"]),
        count(made["triangles"]), kilobytes(made["bytes"]), kilobytes(gzip["levels"][level]["bytes_in_files"]), f"{seconds:.1f}",
    ]


def count(number):
    return f"{number:,}"


def number(metres):
    """Four digits or more."""
    return count(round(metres)) if metres >= 1000 else f"{metres:.4g}"


def kilobytes(size):
    return count(round(size / 1000)) if size >= 9950 else f"{size / 1000:.1f}"


if __name__ == "__main__":
    main()
