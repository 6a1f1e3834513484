"""What `terrabite.simplify` takes beyond the array it is given, and pydelatin. Called by `make bench`, after the build.

Prints, for the default options and one thread, the peak of the process's memory less what it was with the array loaded, in
bytes for each sample; of pydelatin its whole process, as it keeps copies of the array.
"""

import argparse
import os
import subprocess
import sys
from pathlib import Path

from bench_common import GDAL_FLOOR, ROOT, WORK, run
from environment import python_with

DATA = Path(os.environ.get("TERRABITE_DATA", ROOT / ".." / "shared" / "data"))
NAME, SIDE, TOLERANCE = "moon_tycho_4096", 4096, 20

# In a process of its own, which has done nothing else: the most memory that the system has counted from here on.
MEASURED = """
import sys
import numpy as np
import terrabite as tb

def status(name):
    with open("/proc/self/status") as file:
        return next(1024 * int(line.split()[1]) for line in file if line.startswith(name))

heights = np.fromfile(sys.argv[1], dtype="float32").reshape(int(sys.argv[2]), -1)
with open("/proc/self/clear_refs", "w") as file:
    file.write("5")
before = status("VmRSS")
tin = tb.simplify(heights, max_error=float(sys.argv[3]), threads=1)
print((status("VmHWM") - before) / heights.size, len(tin.triangles))
"""


def main():
    argparse.ArgumentParser(description=__doc__.splitlines()[0]).parse_args()
    raster = DATA / f"{NAME}.tif"
    if not raster.exists():
        print(f"From Python: {NAME} is not there, so nothing is measured")
        return
    WORK.mkdir(parents=True, exist_ok=True)
    raw = WORK / f"{NAME}.f32"
    if not raw.exists() or raw.stat().st_size != 4 * SIDE**2:
        run(GDAL_FLOOR, "raw", raster, raw)
    python = environment()
    measured = run(python, "-c", MEASURED, raw, SIDE, TOLERANCE)
    bytes_a_sample, triangles = measured.printed.split()
    peer = run(peer_environment(), ROOT / "scripts" / "bench_pydelatin.py", raw, SIDE, SIDE, TOLERANCE)
    print(f"From Python, {NAME} at {TOLERANCE}, default options, one thread, {SIDE**2} samples:")
    print(f"  terrabite.simplify: {float(bytes_a_sample):.2f} bytes a sample beyond the array and {triangles} triangles")
    print(f"  pydelatin, its whole process: {peer.peak / SIDE**2:.2f} bytes a sample")


def environment():
    """The environment of the package's tests, with the wheel of this tree."""
    script = ROOT / "scripts" / "python_tests.py"
    built = subprocess.run([sys.executable, script, "--install"], stdout=subprocess.PIPE, text=True)
    if built.returncode != 0:
        sys.exit("bench: the Python package cannot be built (see above)")
    return built.stdout.split()[-1]


def peer_environment():
    return python_with(ROOT / "scripts" / "bench-requirements.txt", WORK / "venv")


if __name__ == "__main__":
    main()
