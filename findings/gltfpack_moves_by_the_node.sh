#!/usr/bin/env bash
# Version: gltfpack 1.3.0, run by node.
#
# The good guess: a terrain in projected coordinates keeps its precision as a GLB if its positions are small and a node's
# translation, which glTF has in doubles, puts them on the map. gltfpack -noq, "no quantization", keeps positions as they
# are, and the translation with them.
#
# What happens: gltfpack adds the translation to the positions in single precision and drops it from the node. At a
# northing of 5.2 million a single has steps of half a metre, so vertices 0.25 m apart fall together, and triangles
# vanish. Custom data of the asset ("extras") are kept, so an origin that is written there as well counts twice for whoever
# reads it. With -kn (keep named nodes) the node and the positions stay.
#
# Why it matters: meshes of DEMs with cells below a metre lose their shape without a word, and a program that takes the
# origin from extras puts the mesh at twice its coordinates.
set -euo pipefail

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
npm install --silent --no-audit --no-fund --prefix "$work" gltfpack@1.3.0 >/dev/null

cat >make.py <<'PYTHON'
"""A grid of triangles, 0.25 m from vertex to vertex, at UTM coordinates: y is up, so north is -z."""
import json
import struct

side = 9
places = [(0.25 * c, 10.0 + (c * r) % 3, -0.25 * r) for r in range(side) for c in range(side)]
faces = []
for a in (r * side + c for r in range(side - 1) for c in range(side - 1)):
    faces += [(a, a + 1, a + side + 1), (a, a + side + 1, a + side)]
vertices = b"".join(struct.pack("<3f", *place) for place in places)
corners = b"".join(struct.pack("<3H", *face) for face in faces)
document = {
    "asset": {"version": "2.0", "extras": {"origin": [500000.0, 0.0, -5200000.0]}},
    "scene": 0, "scenes": [{"nodes": [0]}],
    "nodes": [{"name": "tin", "mesh": 0, "translation": [500000.0, 0.0, -5200000.0]}],
    "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
    "accessors": [
        {"bufferView": 0, "componentType": 5126, "count": len(places), "type": "VEC3",
         "min": [min(p[i] for p in places) for i in range(3)], "max": [max(p[i] for p in places) for i in range(3)]},
        {"bufferView": 1, "componentType": 5123, "count": 3 * len(faces), "type": "SCALAR"},
    ],
    "bufferViews": [
        {"buffer": 0, "byteLength": len(vertices), "target": 34962},
        {"buffer": 0, "byteOffset": len(vertices), "byteLength": len(corners), "target": 34963},
    ],
    "buffers": [{"byteLength": len(vertices) + len(corners)}],
}
text = json.dumps(document).encode()
text += b" " * (-len(text) % 4)
data = vertices + corners
data += b"\0" * (-len(data) % 4)
with open("in.glb", "wb") as f:
    f.write(struct.pack("<4sII", b"glTF", 2, 28 + len(text) + len(data)))
    f.write(struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(data), b"BIN\0") + data)
print(f"in:       {len(places)} vertices, {len(faces)} triangles")
PYTHON
cat >look.py <<'PYTHON'
"""What is in a GLB: counts, the node, the extras, and the distinct places."""
import json
import struct
import sys

content = open(sys.argv[1], "rb").read()
length = struct.unpack_from("<I", content, 12)[0]
document, data = json.loads(content[20:20 + length]), content[28 + length:]
primitive = document["meshes"][0]["primitives"][0]
accessor = document["accessors"][primitive["attributes"]["POSITION"]]
view = document["bufferViews"][accessor["bufferView"]]
stride = view.get("byteStride", 12)
begin = view.get("byteOffset", 0) + accessor.get("byteOffset", 0)
places = {struct.unpack_from("<3f", data, begin + i * stride) for i in range(accessor["count"])}
triangles = document["accessors"][primitive["indices"]]["count"] // 3
node = next(n for n in document["nodes"] if "mesh" in n)
print(json.dumps({"vertices": len(places), "triangles": triangles, "translation": node.get("translation"),
                  "extras": "origin" in document["asset"].get("extras", {}), "a place": min(places)}))
PYTHON
python3 make.py
packed() {
    node_modules/.bin/gltfpack -i in.glb -o "$1.glb" "${@:2}" >/dev/null
    python3 look.py "$1.glb"
}
node_modules/.bin/gltfpack -v 2>&1 | head -1 || true
plain=$(packed plain -noq)
kept=$(packed kept -noq -kn)
echo "-noq:     $plain"
echo "-noq -kn: $kept"
python3 - "$plain" "$kept" <<'PYTHON'
import json
import sys

plain, kept = map(json.loads, sys.argv[1:])
assert plain["translation"] is None and plain["a place"][2] < -5_000_000, "the translation is in the positions"
assert plain["vertices"] < 81, "vertices have fallen together"
assert plain["extras"], "the origin is told once more"
assert kept["vertices"] == 81 and kept["triangles"] == 128 and kept["translation"][2] == -5200000
PYTHON
