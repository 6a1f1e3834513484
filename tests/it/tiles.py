"""Decodes a set of tiles with quantized-mesh-tile and by the specification, and compares vertex by vertex."""

import json
import struct
import sys
from pathlib import Path

from quantized_mesh_tile import decode
from quantized_mesh_tile.global_geodetic import GlobalGeodetic


def by_the_specification(data):
    """Vertices (u, v, height) and triangles of a tile."""
    least, greatest = struct.unpack_from("<ff", data, 24)
    (count,) = struct.unpack_from("<I", data, 88)
    codes = struct.unpack_from(f"<{3 * count}H", data, 92)
    columns = []
    for first in (0, count, 2 * count):
        value, column = 0, []
        for code in codes[first : first + count]:
            value += (code >> 1) ^ -(code & 1)
            column.append(value)
        columns.append(column)
    at = 92 + 6 * count
    (triangles,) = struct.unpack_from("<I", data, at)
    highest, indices = 0, []
    for code in struct.unpack_from(f"<{3 * triangles}H", data, at + 4):
        indices.append(highest - code)
        highest += code == 0
    heights = [least + (greatest - least) * h / 32767 for h in columns[2]]
    return columns[0], columns[1], heights, indices


def main(folder):
    layer = json.loads((folder / "layer.json").read_text())
    geodetic = GlobalGeodetic(True)
    tiles = vertices = 0
    for level, ranges in enumerate(layer["available"]):
        for r in ranges:
            for x in range(r["startX"], r["endX"] + 1):
                for y in range(r["startY"], r["endY"] + 1):
                    path = folder / f"{level}/{x}/{y}.terrain"
                    bounds = geodetic.TileBounds(x, y, level)
                    tile = decode(str(path), bounds, hasLighting=True)
                    u, v, heights, indices = by_the_specification(path.read_bytes())
                    assert list(tile.u) == u and list(tile.v) == v, path
                    assert list(tile.indices) == indices, path
                    west, south, east, north = bounds
                    for i, (lon, lat, height) in enumerate(tile.getVerticesCoordinates()):
                        assert abs(height - heights[i]) < 1e-9, (path, i)
                        assert abs(lon - (west + (east - west) * u[i] / 32767)) < 1e-9, (path, i)
                        assert abs(lat - (south + (north - south) * v[i] / 32767)) < 1e-9, (path, i)
                    for edge, on in ((tile.westI, (u, 0)), (tile.southI, (v, 0)), (tile.eastI, (u, 32767)), (tile.northI, (v, 32767))):
                        assert sorted(edge) == [i for i, c in enumerate(on[0]) if c == on[1]], path
                    assert len(tile.vLight) == len(u), path
                    tiles, vertices = tiles + 1, vertices + len(u)
    print(f"agreed: {tiles} tiles, {vertices} vertices")


main(Path(sys.argv[1]))
