"""What every --quality is worth: triangles and time against pydelatin at equal tolerance. Called by `make bench-quality`.

Every raster of the data folder without nodata is simplified at three tolerances, one for each range of samples per
triangle (4 to 20, 20 to 100, 100 to 700 of greedy insertion's). Every mesh is judged by `terrabite verify`. Times are
taken inside the processes, of triangulation alone, and compared on rasters of at least 4 million samples. Prints tables
for docs/quality.md, the last of them of how the meshes look along seams and the rim (bench_looks.py). With `--against REV`
another commit takes pydelatin's place (bench_against.py).
"""

import argparse
import statistics
import sys
from pathlib import Path

import bench_against
import bench_budgets
import bench_looks
from bench import DATA, described, environment, peer
from bench_common import (
    TERRABITE, WORK, geometric, grouped, machine, note, print_table, run, settle, simplify, verified,
)

# Name, tolerances by range.
CASES = [
    ("crater_lake_garland", ["4", "12", "40"]),
    ("srtm3_S33W071", ["40", "100", "250"]),
    ("srtm3_N57E011", ["2", "6", "16"]),
    ("srtm3_mosaic_n_england", ["6", "15", "40"]),
    ("lidar_wetland_1m", ["0.1", "0.25", "0.7"]),
    ("mars_mola_4ppd", ["500", "1000", "2500"]),
    ("moon_tycho_4096", ["10", "30", "100"]),
    ("moon_highlands_8192", ["10", "30", "100"]),
]
RANGES = ["4 to 20", "20 to 100", "100 to 700"]
QUALITIES = {
    "none": ["--quality", "none", "--engine", "greedy-cuts"],
    "fast": ["--quality", "fast"],
    "balanced": ["--quality", "balanced"],
    "balanced, fitted": ["--quality", "balanced", "--heights", "fitted"],
    "best": ["--quality", "best"],
    "best, fitted": ["--quality", "best", "--heights", "fitted"],
}
# What is compared with another commit, unless others are chosen.
AGAINST = ["fast", "balanced", "balanced, fitted"]
LOOKS = {**QUALITIES, **bench_looks.ONE_TILE}
LARGE = 4_000_000


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--only", default="", help="only rasters whose name contains this")
    parser.add_argument("--large", action="store_true", help="only rasters of at least 4 million samples")
    parser.add_argument("--tolerances", default="", help="only these of each raster's, between commas")
    parser.add_argument("--qualities", default="", help=f"some of these, between semicolons: {'; '.join(QUALITIES)}")
    parser.add_argument("--patience", type=float, default=5, help="seconds to wait for idle cores before a run")
    parser.add_argument("--against", metavar="REV", help=f"build this commit and compare with it, by default {'; '.join(AGAINST)}")
    parser.add_argument("--rounds", type=int, default=3, help="with --against: runs of each build")
    parser.add_argument("--peer", action="store_true", help="with --against: pydelatin, too")
    parser.add_argument(
        "--looks", nargs="?", const=bench_looks.CASES, metavar="CASES",
        help=f"only how meshes look along seams and the rim, by default balanced ones of '{bench_looks.CASES}'; "
        f"another quality is {'; '.join(bench_looks.ONE_TILE)}",
    )
    parser.add_argument(
        "--budgets", nargs="?", const=bench_budgets.CASES, metavar="CASES",
        help=f"only what budgets of triangles come to, by default '{bench_budgets.CASES}'",
    )
    arguments = parser.parse_args()
    wanted = chosen(arguments)
    WORK.mkdir(parents=True, exist_ok=True)
    if arguments.budgets is not None:
        print("\n".join(machine()))
        bench_budgets.report(arguments.budgets, arguments)
        return
    if arguments.looks is not None:
        print("\n".join(machine()))
        bench_looks.report(arguments.looks, {q: LOOKS[q] for q in wanted}, arguments)
        return
    other = bench_against.Build(arguments.against) if arguments.against else None
    header, chosen_cases = machine(), list(cases(arguments))
    if not chosen_cases:
        sys.exit(f"bench: no case is left: see --only, --large and --tolerances, and the rasters in {DATA}")
    if other:
        pairs = [
            bench_against.measure(raster, tolerance, q, QUALITIES[q], raster.samples >= LARGE, other, arguments)
            for raster, tolerance, _ in chosen_cases
            for q in wanted
        ]
        print("\n".join(header))
        bench_against.report(pairs, other, arguments)
    if arguments.peer or not other:
        against_peer(chosen_cases, wanted, header, arguments)
        print()
        bench_looks.report(bench_looks.CASES, {"balanced": QUALITIES["balanced"]}, arguments)


def chosen(arguments):
    """The qualities that are asked for."""
    names = [name.strip() for name in arguments.qualities.split(";") if name.strip()]
    there_are = QUALITIES if arguments.looks is None else LOOKS
    unknown = [name for name in names if name not in there_are]
    if unknown:
        sys.exit(f"bench: unknown qualities: {'; '.join(unknown)} (there are {'; '.join(there_are)})")
    if arguments.looks is not None:
        return names or ["balanced"]
    return names or (AGAINST if arguments.against else list(QUALITIES))


def cases(arguments):
    """Rasters, tolerances and ranges of density that are asked for."""
    tolerances = [float(t) for t in arguments.tolerances.split(",") if t.strip()]
    for name, of_raster in CASES:
        path = DATA / f"{name}.tif"
        if arguments.only not in name:
            continue
        if not path.exists():
            note(f"{path} is not there: left out")
            continue
        raster = described(name, path)
        if arguments.large and raster.samples < LARGE:
            continue
        for tolerance, density in zip(of_raster, RANGES):
            if not tolerances or float(tolerance) in tolerances:
                yield raster, tolerance, density


def against_peer(chosen_cases, wanted, header, arguments):
    python = environment()
    rows, shares, speeds = [], {q: [] for q in wanted}, {q: [] for q in wanted}
    for raster, tolerance, density in chosen_cases:
        compare(raster, tolerance, density, python, arguments, wanted, rows, shares, speeds)
    print("\n".join(header))
    print(f"Peer: {peer(python)}; {arguments.threads} threads against its one\n")
    columns = ["raster, tolerance", "quality", "samples each", "triangles", "÷ peer", "RMS ÷ tolerance",
               "smallest angle, 5 % / 50 %", "edges beyond, %", "seconds", "speed ÷ peer"]
    print_table(columns, rows)
    print()
    summary = []
    for q in wanted:
        fast = f"{geometric(speeds[q]):.2f}" if speeds[q] else ""
        summary.append([q, f"{geometric(shares[q]):.3f}" if shares[q] else "", fast])
    print_table(["quality, geometric means", "triangles ÷ peer", "speed ÷ peer, large rasters"], summary)


def compare(raster, tolerance, density, python, arguments, wanted, rows, shares, speeds):
    note(f"{raster.name} at {tolerance}")
    child = [python, Path(__file__).with_name("bench_pydelatin.py"), raster.raw, raster.width, raster.height, tolerance]
    mesh = WORK / "quality.ply"
    settle(arguments.patience)
    runs = [run(*child).json()]
    if raster.samples >= LARGE:
        # A second one after ours: a machine that slows down or speeds up meanwhile hits both.
        measured = {q: simplified(raster, tolerance, QUALITIES[q], mesh, arguments) for q in wanted}
        runs.append(run(*child).json())
    else:
        measured = {q: simplified(raster, tolerance, QUALITIES[q], mesh, arguments) for q in wanted}
    theirs = runs[0]["triangles"]
    seconds = statistics.mean(r["triangulate_seconds"] for r in runs)
    rows.append([f"{raster.name}, {tolerance}", "pydelatin", f"{raster.samples / theirs:.1f}", grouped(theirs), "1", "", "", "",
                 f"{seconds:.2f}", "1"])
    for q, report in measured.items():
        share, took = report["triangles"] / theirs, report["seconds"]["tiles"]
        shares[q].append(share)
        if raster.samples >= LARGE:
            speeds[q].append(seconds / took)
        shape = report["shape"] or {}
        rows.append([
            f"{raster.name}, {tolerance}", q, f"{report['samples_per_triangle']:.1f}", grouped(report["triangles"]), f"{share:.3f}",
            f"{report['error']['rms'] / float(tolerance):.3f}", f"{shape['angle_p5']:.0f}° / {shape['angle_p50']:.0f}°" if shape else "",
            f"{100 * shape['edges_beyond']:.1f}" if shape else "", f"{took:.2f}", f"{seconds / took:.2f}",
        ])
    low, high = (float(d) for d in density.split(" to "))
    if not low <= raster.samples / theirs <= high:
        note(f"{raster.samples / theirs:.1f} samples per triangle of the peer are not {density}")


def simplified(raster, tolerance, options, mesh, arguments):
    settle(arguments.patience)
    done = simplify(TERRABITE, raster.path, mesh, tolerance, arguments.threads, options)
    verified(raster.path, mesh, tolerance)
    mesh.unlink()
    return done.json()


if __name__ == "__main__":
    main()
