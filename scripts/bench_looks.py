"""Whether seams and the rim of a mesh can be seen. Called by bench_quality.py; `--looks` runs this part alone.

Every mesh is judged by `terrabite verify`, then `examples/looks.rs` holds its hillshade against the raster's: the 99.9th
percentile of the difference within two cells of tile lines, of lines through the middle of tiles (where no seam is) and
of the raster's rim, each divided by the same elsewhere. What exactly is measured stands in docs/quality.md, "Looks".
"""

import sys
from dataclasses import dataclass
from pathlib import Path

from bench import DATA
from bench_common import TARGET, TERRABITE, WORK, note, print_table, run, simplify, verified

LOOKS = TARGET / "release" / "examples" / "looks"
CASES = "moon_tycho_4096 100; srtm3_mosaic_n_england 20; crater_lake_garland 5"
# Cells in a side of the default tile: the lines that are looked at, also in meshes of one tile.
TILE = 512
ONE_TILE = {"balanced, one tile": ["--quality", "balanced", "--tile", "0", "--memory", "8GiB"]}
# What tile lines and the rim may be, as multiples of elsewhere.
GOALS = {"tile_lines": 1.05, "rim": 1.5}
HEADER = [
    "raster, tolerance", "quality", "vertical scale", "elsewhere", f"tile lines ÷ it (goal {GOALS['tile_lines']})",
    "between them ÷ it", f"rim ÷ it (goal {GOALS['rim']})",
]


@dataclass
class Case:
    path: Path
    tolerance: str


def cases(text):
    """From `RASTER TOLERANCE; RASTER TOLERANCE; …`: names in the data folder, or paths."""
    found = []
    for words in (part.split() for part in text.split(";") if part.strip()):
        if len(words) != 2:
            sys.exit(f"bench: expected --looks 'RASTER TOLERANCE; …', found {' '.join(words)}")
        path = next((p for p in (DATA / f"{words[0]}.tif", Path(words[0])) if p.is_file()), None)
        if path:
            found.append(Case(path, words[1]))
        else:
            note(f"{words[0]} is not there: left out")
    return found


def report(text, qualities, arguments):
    """Measures the cases with every quality (a name, and its options) and prints a table."""
    mesh, rows = WORK / "looks.ply", []
    for case in cases(text):
        for quality, options in qualities.items():
            note(f"looks of {case.path.stem} at {case.tolerance}, {quality}")
            simplify(TERRABITE, case.path, mesh, case.tolerance, arguments.threads, options)
            verified(case.path, mesh, case.tolerance)
            rows.append(row(case, quality, run(LOOKS, case.path, mesh, TILE).json()))
            mesh.unlink()
    print("Difference of hillshades, 99.9th percentile\n")
    print_table(HEADER, rows)


def row(case, quality, looks):
    def ratio(strip):
        found = (looks[strip] or {}).get("ratio")
        if found is None:
            return "–"
        missed = found > GOALS.get(strip, found)
        return f"{found:.3f}{' (missed)' if missed else ''}"

    return [
        f"{case.path.stem}, {case.tolerance}", quality, f"{looks['vertical_scale']:.3g}", f"{looks['elsewhere']['difference']:.4f}",
        ratio("tile_lines"), ratio("shifted_lines"), ratio("rim"),
    ]
