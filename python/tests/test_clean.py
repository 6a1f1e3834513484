"""What holds where nothing but numpy is installed."""

from __future__ import annotations

import importlib.util
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import terrabite as tb

LACKS = [name for name in ("rasterio", "trimesh", "pyvista", "meshio") if importlib.util.find_spec(name) is None]


def test_the_module_needs_no_library_that_has_to_be_installed():
    module = Path(tb._terrabite.__file__)
    ldd = subprocess.run(["ldd", module], capture_output=True, text=True, check=True).stdout
    names = {line.split()[0].partition(".so")[0].rpartition("/")[2] for line in ldd.splitlines()}
    # What every manylinux has.
    assert names <= {"linux-vdso", "libstdc++", "libgcc_s", "libm", "libc", "libdl", "libpthread", "librt", "ld-linux-x86-64"}, ldd


def test_what_is_missing_is_named(dem):
    tin = tb.simplify(dem, 2)
    calls = {"trimesh": tin.to_trimesh, "pyvista": tin.to_pyvista, "meshio": tin.to_meshio}
    for name, call in calls.items():
        if name in LACKS:
            with pytest.raises(ImportError, match=f"pip install {name}"):
                call()
    if "rasterio" in LACKS:
        with pytest.raises(ImportError, match="pip install rasterio"):
            tb.simplify("dem.tif", 2)


def test_importing_it_loads_no_library_that_it_can_do_without():
    code = "import sys, terrabite; print({'rasterio', 'trimesh', 'pyvista', 'meshio'} & set(sys.modules))"
    assert subprocess.run([sys.executable, "-P", "-c", code], capture_output=True, text=True, check=True).stdout == "set()\n"


def test_a_mesh_is_written_and_judged(tmp_path, dem):
    tin = tb.simplify(dem, 2)
    tin.write(tmp_path / "a.glb")
    assert tb.verify(dem, tmp_path / "a.glb", 2.001) and np.isfinite(tin.vertices).all()
