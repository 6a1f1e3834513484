#!/usr/bin/env bash
# Version: @loaders.gl/core and @loaders.gl/terrain 4.5.4, run by node.
#
# The good guess: parse(buffer, QuantizedMeshLoader) reads the buffer of a terrain tile. Parsing it once more gives the same mesh,
# as parsing an image or a point cloud does, and a buffer that a program keeps (a cache of tiles, a service worker) stays a tile.
#
# What happens: where parsing takes place in the same thread (core.worker: false, or node), the triangles are decoded within the
# caller's buffer. The second time they are decoded from what has been decoded already: the mesh has indices up to 65535
# into its few vertices, and no error is raised. The first mesh shares the buffer, so its triangles change too, while it is in use.
# Besides, header.vertexCount of a mesh is its number of indices, not of vertices.
#
# Why it matters: a client that decodes a tile again, with other bounds or another skirtHeight say, draws garbage or reads beyond
# the vertices, and has lost the good mesh as well. Each call needs a copy: parse(buffer.slice(0), …).
set -euo pipefail

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
echo '{}' >package.json
npm install --silent --no-audit --no-fund --ignore-scripts @loaders.gl/core@4.5.4 @loaders.gl/terrain@4.5.4 >/dev/null

cat >twice.cjs <<'NODE'
const assert = require('node:assert/strict');
const { parse } = require('@loaders.gl/core');
const { QuantizedMeshLoader } = require('@loaders.gl/terrain');

// A square of two triangles, 100 m high: south-west, south-east, north-east, north-west.
const corners = [[0, 0], [32767, 0], [32767, 32767], [0, 32767]];
const triangles = [0, 1, 2, 0, 2, 3];
function tile() {
  const bytes = Buffer.alloc(88 + 4 + 24 + 4 + 12 + 4 * 8);
  bytes.writeFloatLE(100, 24);
  bytes.writeFloatLE(100, 28);
  let at = 88;
  const count = value => { at = bytes.writeUInt32LE(value, at); };
  const short = value => { at = bytes.writeUInt16LE(value, at); };
  count(corners.length);
  for (const column of [0, 1, 2]) {
    let before = 0;
    for (const corner of corners) {
      const value = corner[column] ?? 0, delta = value - before;
      short((delta << 1) ^ (delta >> 31));
      before = value;
    }
  }
  count(triangles.length / 3);
  let highest = 0;
  for (const index of triangles) {
    short(highest - index);
    highest += Number(index === highest);
  }
  for (const side of [[0, 3], [0, 1], [1, 2], [3, 2]]) {
    count(side.length);
    side.forEach(short);
  }
  return new Uint8Array(bytes).buffer;
}

async function main() {
  const options = { worker: false, core: { worker: false } };
  const read = async buffer => parse(buffer, QuantizedMeshLoader, options);
  const indices = mesh => Array.from(mesh.indices.value);
  const buffer = tile(), untouched = tile();
  const first = await read(buffer);
  const before = indices(first);
  const second = await read(buffer);
  console.log(`in the tile:         ${triangles}`);
  console.log(`parsed once:         ${before}`);
  console.log(`parsed again:        ${indices(second)}`);
  console.log(`the first mesh then: ${indices(first)}`);
  console.log(`header.vertexCount:  ${first.header.vertexCount} of ${first.attributes.POSITION.value.length / 3} vertices`);
  assert.deepEqual(before, triangles);
  assert(Math.max(...indices(second)) > 60000, 'indices beyond the vertices');
  assert.deepEqual(indices(first), indices(second), 'the first mesh has changed');
  assert.notDeepEqual(new Uint8Array(buffer), new Uint8Array(untouched), 'the buffer is no tile any more');
  assert.equal(first.header.vertexCount, triangles.length);
  const copies = [await read(untouched.slice(0)), await read(untouched.slice(0))];
  copies.forEach(mesh => assert.deepEqual(indices(mesh), triangles));
}

main();
NODE
node twice.cjs
