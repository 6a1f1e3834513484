"""Meshes as files, and in the hands of other libraries."""

from __future__ import annotations

import numpy as np
import pytest
import terrabite as tb

PLACE = {"transform": (500_000.12, 0.25, 0.0, 5_200_000.77, 0.0, -0.25), "crs": "EPSG:32633"}


@pytest.mark.parametrize("name", ["a.ply", "a.obj", "a.glb", "a.stl", "a.xml", "a.nc", "a.vtp", "a.2dm"])
def test_every_format_is_written_and_is_within_the_bound_that_it_states(tmp_path, dem, name):
    # Heights that single precision does not hold.
    heights = dem + 0.1
    tin = tb.simplify(heights, 2, **PLACE)
    written = tin.write(tmp_path / name)
    assert written["triangles"] == len(tin.triangles) and written["max_error"] == pytest.approx(2, abs=1e-4)
    assert written["max_error"] >= 2 and (written["loss"] > 0) == (written["precision"] == "float")
    assert tb.verify(heights, tmp_path / name, written["max_error"], **PLACE).passed
    with pytest.raises(tb.OutputError, match="exists"):
        tin.write(tmp_path / name)
    assert tin.write(tmp_path / name, overwrite=True) == written


def test_edges_that_follow_breaklines_are_there_and_are_written(tmp_path, dem):
    line = np.array([[3.2, -2.1], [dem.shape[1] - 4.0, -dem.shape[0] + 3.5]])
    tin = tb.simplify(dem, 2, breaklines=[line])
    edges = tin.breakline_edges
    assert edges.dtype == np.uint32 and edges.shape == (tin.report["breaklines"]["chains"]["edges"], 2) and len(edges) > 1
    assert (edges[1:, 0] == edges[:-1, 1]).all() and not edges.flags.writeable
    sides = {frozenset(side) for a, b, c in tin.triangles.tolist() for side in ((a, b), (b, c), (c, a))}
    assert all(frozenset(edge) in sides for edge in edges.tolist())
    assert tin.write(tmp_path / "a.ply")["edges"] == len(edges)
    assert f"\nelement edge {len(edges)}\n".encode() in (tmp_path / "a.ply").read_bytes()
    assert tb.simplify(dem, 2).breakline_edges.shape == (0, 2)
    assert tin.breakline_types.tolist() == ["hard"] * len(edges)
    soft = tb.simplify(dem, 2, breaklines=[line, line[::-1] * [1, 0.5]], breakline_type=["hard", "soft"])
    types = soft.breakline_types
    assert types.shape == soft.breakline_edges.shape[:1] and set(types) == {"hard", "soft"}
    assert (types == "soft").sum() == soft.report["breaklines"]["soft_edges"]
    soft.write(tmp_path / "b.ply")
    assert b"property uchar soft" in (tmp_path / "b.ply").read_bytes()
    assert tb.verify(dem, soft, 2, breaklines=[line, line[::-1] * [1, 0.5]]).passed
    for wrong in ("firm", ["hard"], ["hard", "firm"]):
        with pytest.raises(ValueError, match="breakline_type"):
            tb.simplify(dem, 2, breaklines=[line, line], breakline_type=wrong)
    with pytest.raises(ValueError, match="breakline_type"):
        tb.simplify(dem, 2, breakline_type="soft")


def test_single_precision_adds_its_loss_to_the_bound(tmp_path, dem):
    heights = dem + 1e4 / 3
    tin = tb.simplify(heights, 0.5)
    exact, rounded = tin.write(tmp_path / "a.ply"), tin.write(tmp_path / "b.ply", precision="float")
    assert exact["loss"] == 0 and exact["max_error"] == 0.5
    assert 0 < rounded["loss"] < 1e-3 and rounded["max_error"] == 0.5 + rounded["loss"]
    assert b"max_error" in (tmp_path / "b.ply").read_bytes()[:2000]


def test_formats_take_their_options_and_no_others(tmp_path, dem):
    tin = tb.simplify(dem, 4)
    solid = tin.write(tmp_path / "a.stl", base_depth=10)
    assert solid["triangles"] == len(tin.triangles)
    assert (tmp_path / "a.stl").stat().st_size > 84 + 50 * len(tin.triangles)
    tin.write(tmp_path / "a.ply", ascii=True)
    assert (tmp_path / "a.ply").read_text().startswith("ply\nformat ascii")
    tin.write(tmp_path / "a.glb", mesh_compression="meshopt")
    tin.write(tmp_path / "mesh", format="vtp")
    for options in (
        {"path": tmp_path / "b.obj", "base_depth": 1},
        {"path": tmp_path / "b.stl", "base_depth": -1},
        {"path": tmp_path / "b.ply", "mesh_compression": "meshopt"},
        {"path": tmp_path / "b.ply", "precision": "half"},
        {"path": tmp_path / "b.tif"},
        {"path": tmp_path / "b.ply", "format": "dxf"},
    ):
        with pytest.raises(ValueError):
            tin.write(**options)
    with pytest.raises(tb.OutputError):
        tin.write(tmp_path / "no such folder" / "a.ply")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.glb", "a.ply", "a.stl", "mesh"]


def test_a_damaged_file_is_an_error_and_a_wrong_mesh_a_verdict(tmp_path, dem):
    tin = tb.simplify(dem, 2)
    tin.write(tmp_path / "a.ply")
    (tmp_path / "b.ply").write_bytes((tmp_path / "a.ply").read_bytes()[:-5])
    with pytest.raises(tb.MeshError):
        tb.verify(dem, tmp_path / "b.ply", 2)
    with pytest.raises(tb.MeshError):
        tb.verify(dem, tmp_path / "none.ply", 2)
    verdict = tb.verify(dem, tmp_path / "a.ply", 0.5)
    assert not verdict and not verdict.passed and verdict.failures and "within" not in repr(verdict)[:5]
    assert verdict.report["passed"] is False


def test_trimesh_and_meshio_have_the_same_mesh(dem):
    tin = tb.simplify(dem, 2, attributes={"rough": np.ones_like(dem, dtype="float32")}, quality="none")
    mesh = tin.to_trimesh()
    assert np.array_equal(mesh.vertices, tin.vertices) and np.array_equal(mesh.faces, tin.triangles)
    assert list(mesh.vertex_attributes) == ["rough"]
    mesh = tin.to_meshio()
    assert np.array_equal(mesh.points, tin.vertices) and np.array_equal(mesh.cells_dict["triangle"], tin.triangles)
    assert np.array_equal(mesh.point_data["rough"], np.ones(len(tin.vertices)))


@pytest.mark.readers
def test_pyvista_has_the_same_mesh(dem):
    pytest.importorskip("pyvista")
    tin = tb.simplify(dem, 2)
    mesh = tin.to_pyvista()
    assert np.array_equal(mesh.points, tin.vertices) and np.array_equal(mesh.regular_faces, tin.triangles)


def test_coordinates_are_local_and_heights_scaled_where_asked(tmp_path, dem):
    tin = tb.simplify(dem, 2, normals="area", **PLACE)
    assert list(tin.attributes) == ["nx", "ny", "nz"]
    normals = np.stack(list(tin.attributes.values()), axis=1)
    assert np.allclose(np.linalg.norm(normals, axis=1), 1, atol=1e-6) and (normals[:, 2] > 0).all()
    written = tin.write(tmp_path / "a.ply", local=True, z_scale=0.3)
    assert written["z_scale"] == 0.3 and written["offset"][0] > 4e5 and written["loss"] < 1e-12
    assert tb.verify(dem, tmp_path / "a.ply", written["max_error"], **PLACE).passed
    assert b"property float nz" in (tmp_path / "a.ply").read_bytes()[:3000]
    for z_scale in (0, -1, float("inf"), float("nan")):
        with pytest.raises(ValueError, match="z_scale"):
            tin.write(tmp_path / "b.ply", z_scale=z_scale)
    assert not (tmp_path / "b.ply").exists()
