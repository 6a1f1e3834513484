"""What a budget comes to with polishing and without. Called by bench_quality.py: `--budgets` runs this part alone.

Every mesh is judged by `terrabite verify`: the polished one at the tolerance that was found, the other at its largest error.
How much longer it takes is told by a run with that tolerance alone. Prints a table for docs/quality.md.
"""

from bench_common import TERRABITE, WORK, geometric, grouped, note, print_table, run, verified
from bench_looks import cases

CASES = "; ".join(
    f"{raster} {budget}"
    for raster in ("moon_tycho_4096", "srtm3_mosaic_n_england")
    for budget in (50_000, 200_000, 500_000)
)
HEADER = [
    "raster, triangles", "largest error, unpolished", "polished", "ratio", "of the budget", "runs", "CPU seconds",
    "a run with that tolerance", "ratio",
]


def report(text, arguments):
    """Measures cases, `RASTER BUDGET; …`, and prints a table."""
    mesh, rows, errors, times = WORK / "budget.ply", [], [], []

    def made(case, *options):
        fixed = ["--threads", arguments.threads, "--overwrite", "--temp-dir", WORK, "--json"]
        return run(TERRABITE, "simplify", case.path, mesh, *fixed, *options)

    for case in cases(text):
        budget = ["--max-triangles", case.tolerance]
        note(f"{case.path.stem}, {case.tolerance} triangles")
        plain = made(case, *budget, "--quality", "none").json()["error"]["max"]
        verified(case.path, mesh, plain * (1 + 1e-9))
        searched = made(case, *budget)
        told = searched.json()
        verified(case.path, mesh, told["tolerance"])
        alone = made(case, "--max-error", told["tolerance"])
        assert alone.json()["triangles"] == told["triangles"]
        search, largest = told["goal"]["search"], told["error"]["max"]
        errors.append(largest / plain)
        times.append(searched.cpu / alone.cpu)
        rows.append([
            f"{case.path.stem}, {grouped(int(case.tolerance))}", f"{plain:.4g}", f"{largest:.4g}", f"{errors[-1]:.3f}",
            f"{100 * search['share']:.1f} %", str(search["runs"]), f"{searched.cpu:.1f}", f"{alone.cpu:.1f}", f"{times[-1]:.2f}",
        ])
    mesh.unlink(missing_ok=True)
    if rows:
        mean = ["geometric mean", "", "", f"{geometric(errors):.3f}", "", "", "", "", f"{geometric(times):.2f}"]
        print_table(HEADER, [*rows, mean])
