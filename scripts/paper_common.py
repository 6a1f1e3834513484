"""What the scripts that repeat the papers' experiments share: programs, tables, pages, plots."""

import csv
import io
import os
import subprocess
import sys
from pathlib import Path

from environment import python_with

ROOT = Path(__file__).resolve().parent.parent
TARGET = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target"))
DATA = Path(os.environ.get("TERRABITE_DATA", ROOT.parent / "shared" / "data"))
IMAGES = ROOT / "docs" / "images"


def experiment(program, *arguments):
    """The lines that an example prints, as dictionaries."""
    print("paper:", *arguments, file=sys.stderr, flush=True)
    command = [TARGET / "release" / "examples" / program, *map(str, arguments)]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"paper: {program} {' '.join(map(str, arguments))}: {done.stderr.strip()}")
    return list(csv.DictReader(io.StringIO(done.stdout)))


def table(header, rows):
    lines = ["| " + " | ".join(header) + " |", "|" + "---|" * len(header)]
    return "\n".join(lines + ["| " + " | ".join(str(c) for c in row) + " |" for row in rows])


def grouped(number):
    return f"{number:,}".replace(",", " ")


def fill(page, tables):
    """Replaces what stands between the markers of each table."""
    text = page.read_text()
    for name, made in tables.items():
        begin, end = f"<!-- {name}: made by make paper -->", f"<!-- end of {name} -->"
        before, rest = text.split(begin)
        text = before + begin + "\n" + made + "\n" + end + rest.split(end)[1]
    page.write_text(text)
    print(f"paper: {page} has new tables", file=sys.stderr)


def reexec_with_matplotlib(script):
    """Runs a script again in a virtual environment that has the plotting library."""
    try:
        import matplotlib

        matplotlib.use("Agg")
        return
    except ImportError:
        if os.environ.get("TERRABITE_PAPER") == "again":
            sys.exit("paper: matplotlib cannot be installed (see above)")
        python = python_with(Path(__file__).with_name("paper-requirements.txt"), TARGET / "paper-venv")
        os.execve(python, [str(python), script], {**os.environ, "TERRABITE_PAPER": "again"})
