// Decodes every tile of a set with @here/quantized-mesh-decoder, with loaders.gl and by the specification, and compares vertex by
// vertex; called by tiles_readers.py as tiles_readers.mjs NODE_MODULES SET.

import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import { join } from 'node:path';
import { pathToFileURL } from 'node:url';

const [modules, set] = process.argv.slice(2);
const require = createRequire(pathToFileURL(`${modules}/`));
const here = require('@here/quantized-mesh-decoder').default;
const { parse } = require('@loaders.gl/core');
const { QuantizedMeshLoader } = require('@loaders.gl/terrain');
const LAST = 32767, SKIRT = 100;

const layer = JSON.parse(readFileSync(join(set, 'layer.json'), 'utf8'));
const counts = { tiles: 0, vertices: 0, triangles: 0 };
for (const [level, ranges] of layer.available.entries()) {
  for (const { startX, endX, startY, endY } of ranges) {
    for (let x = startX; x <= endX; x += 1) for (let y = startY; y <= endY; y += 1) await compare(level, x, y);
  }
}
console.log(`${set}: @here/quantized-mesh-decoder and loaders.gl agree on ${JSON.stringify(counts)}`);

async function compare(level, x, y) {
  const name = `${level}/${x}/${y}`;
  const bytes = readFileSync(join(set, `${name}.terrain`));
  // Both decode indices in place: each needs a copy.
  const copy = () => new Uint8Array(bytes).buffer;
  const expected = bySpecification(new DataView(copy()));
  const same = (what, found, wanted) => assert.deepEqual(Array.from(found), Array.from(wanted), `${name}: ${what}`);

  const decoded = here(copy());
  const { minHeight, maxHeight, boundingSphereRadius } = decoded.header;
  same('header', [minHeight, maxHeight, boundingSphereRadius], [expected.least, expected.greatest, expected.radius]);
  same('vertices', decoded.vertexData, expected.columns.flat());
  same('triangles', decoded.triangleIndices, expected.triangles);
  const { westIndices, southIndices, eastIndices, northIndices } = decoded;
  const sides = [westIndices, southIndices, eastIndices, northIndices];
  sides.forEach((side, i) => same(`side ${i}`, side, expected.sides[i]));
  same('normals', decoded.extensions.vertexNormals, expected.normals);

  const [u, v, h] = expected.columns;
  const side = 180 / 2 ** level;
  const bounds = [x * side - 180, y * side - 90, (x + 1) * side - 180, (y + 1) * side - 90];
  // Its places are singles of sums of doubles.
  const span = [bounds[2] - bounds[0], bounds[3] - bounds[1]];
  const range = expected.greatest - expected.least;
  const places = u.flatMap((_, i) => [
    (u[i] / LAST) * span[0] + bounds[0], (v[i] / LAST) * span[1] + bounds[1], (h[i] / LAST) * range + expected.least,
  ]).map(Math.fround);
  // Heights have 15 bits and are multiples of powers of two: no single rounds them.
  const step = range / LAST;
  const isExact = h.every((quantum, i) => places[3 * i + 2] === expected.least + quantum * step);
  assert(isExact, `${name}: heights in single precision`);
  const inThread = { core: { worker: false }, worker: false };
  const read = async options => parse(copy(), QuantizedMeshLoader, { ...inThread, 'quantized-mesh': { bounds, ...options } });
  const plain = await read({});
  same('places in loaders.gl', plain.attributes.POSITION.value, places);
  same('triangles in loaders.gl', plain.indices.value, expected.triangles);
  const skirted = await read({ skirtHeight: SKIRT });
  const positions = skirted.attributes.POSITION.value, corners = skirted.indices.value;
  same('places with a skirt', positions.slice(0, places.length), places);
  same('triangles with a skirt', corners.slice(0, expected.triangles.length), expected.triangles);
  const links = expected.sides.reduce((sum, on) => sum + on.length - 1, 0);
  assert.equal(corners.length - expected.triangles.length, 6 * links, `${name}: triangles of the skirt`);
  for (let i = expected.triangles.length; i < corners.length; i += 3) {
    const heights = [0, 1, 2].map(k => positions[3 * corners[i + k] + 2]);
    const tall = Math.max(...heights) - Math.min(...heights);
    assert(tall >= SKIRT - 0.01, `${name}: a triangle of the skirt that is ${tall} m high`);
  }
  counts.tiles += 1;
  counts.vertices += u.length;
  counts.triangles += expected.triangles.length / 3;
}

function bySpecification(view) {
  let at = 88;
  const count = () => view.getUint32((at += 4) - 4, true);
  const short = () => view.getUint16((at += 2) - 2, true);
  const vertices = count();
  const columns = [0, 1, 2].map(() => {
    let value = 0;
    return Array.from({ length: vertices }, () => {
      const code = short();
      return (value += (code >> 1) ^ -(code & 1));
    });
  });
  let highest = 0;
  const triangles = Array.from({ length: 3 * count() }, () => {
    const code = short();
    const index = highest - code;
    highest += Number(code === 0);
    return index;
  });
  const sides = [0, 1, 2, 3].map(() => Array.from({ length: count() }, short));
  assert.equal(view.getUint8(at), 1);
  at += 1;
  const normals = Array.from({ length: count() }, () => view.getUint8((at += 1) - 1));
  assert.equal(at, view.byteLength, 'nothing follows the normals');
  const [least, greatest] = [24, 28].map(offset => view.getFloat32(offset, true));
  return { least, greatest, radius: view.getFloat64(56, true), columns, triangles, sides, normals };
}
