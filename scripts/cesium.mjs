// Draws sets of tiles in CesiumJS and checks what it finds on them; called by cesium_tests.py.

import assert from 'node:assert/strict';
import { createRequire } from 'node:module';
import { createServer } from 'node:http';
import { extname, join, normalize } from 'node:path';
import { readFileSync, writeFileSync } from 'node:fs';

const { NODE_MODULES, CHROMIUM, OUT } = process.env;
const { chromium } = createRequire(`${NODE_MODULES}/`)('playwright-core');
const cases = JSON.parse(readFileSync(`${OUT}/cases.json`, 'utf8'));
// CesiumJS takes heights between corners from longitude and latitude, not from the triangle in space: the sag of triangles comes
// on top, which is at most this share of a level's error.
const SAG = 0.25;
const PAGE = `<!doctype html><link rel="icon" href="data:,"><link rel="stylesheet" href="/cesium/Widgets/CesiumWidget/CesiumWidget.css">
<body style="margin:0"><div id="globe" style="width:100vw;height:100vh"></div><script>CESIUM_BASE_URL='/cesium/'</script>
<script src="/cesium/Cesium.js"></script>`;
const TYPES = { '.js': 'text/javascript', '.json': 'application/json', '.css': 'text/css', '.terrain': 'application/vnd.quantized-mesh' };

const server = createServer(answer).listen(0, '127.0.0.1');
await new Promise(done => server.once('listening', done));
const origin = `http://127.0.0.1:${server.address().port}`;
// Without a graphics card WebGL is drawn by the processor.
const args = ['--no-sandbox', '--use-angle=swiftshader', '--enable-unsafe-swiftshader'];
const browser = await chromium.launch({ executablePath: CHROMIUM, args });
const rows = [
  '| set | level | allowed, m | largest error by sampleTerrain | drawn from | largest error by getHeight | lost by drawing |',
  '|---|---|---|---|---|---|---|',
];
const byName = {};
for (const one of cases) {
  byName[one.name] = await opened(one);
  check(one, byName[one.name]);
  rows.push(...table(one, byName[one.name]));
  console.log(`${one.name}: as it should be, ${byName[one.name].tiles} tiles`);
}
// Compressed or not, the same heights.
const { hills, 'hills-gzip': compressed } = byName;
if (hills && compressed) assert.deepEqual(compressed.levels, hills.levels);
await browser.close();
server.close();
writeFileSync(`${OUT}/found.md`, rows.join('\n') + '\n');
console.log(rows.join('\n'));

// Files of CesiumJS and of the sets, with the headers that docs/tiles.md has servers send.
function answer(request, response) {
  const path = normalize(decodeURI(new URL(request.url, 'http://host').pathname));
  if (path === '/') return response.writeHead(200, { 'Content-Type': 'text/html' }).end(PAGE);
  const [, folder, ...rest] = path.split('/');
  const file = join(folder === 'cesium' ? `${NODE_MODULES}/cesium/Build/Cesium` : join(OUT, folder), ...rest);
  let content;
  try {
    content = readFileSync(file);
  } catch {
    return response.writeHead(404).end();
  }
  const isCompressed = cases.some(one => one.name === folder && one.promise.gzip) && extname(file) === '.terrain';
  const type = { 'Content-Type': TYPES[extname(file)] ?? 'application/octet-stream' };
  response.writeHead(200, isCompressed ? { ...type, 'Content-Encoding': 'gzip' } : type).end(content);
}

// A set in a page of its own, which says nothing on the console and is answered whatever it asks for.
async function opened(one) {
  const context = await browser.newContext({ viewport: { width: 750, height: 500 } });
  const page = await context.newPage();
  const said = [], tiles = new Set();
  page.on('console', message => said.push(message.text()));
  page.on('pageerror', error => said.push(error.message));
  page.on('requestfailed', request => said.push(`failed: ${request.url()}`));
  page.on('response', response => {
    if (response.url().includes('.terrain')) tiles.add(response.url());
    if (response.status() >= 400) said.push(`${response.status()}: ${response.url()}`);
  });
  page.on('request', request => {
    const url = request.url();
    if (!url.startsWith(origin) && !/^(data|blob):/.test(url)) said.push(`elsewhere: ${url}`);
  });
  await page.goto(origin);
  const found = await page.evaluate(lookUp, one);
  await page.evaluate(setUp);
  for (const view of ['aslant', 'above', 'near']) {
    found[view] = await page.evaluate(drawn, { ...one, view });
    await page.screenshot({ path: `${OUT}/${one.name}-${view}.png` });
  }
  found.picked = await page.evaluate(pick, one);
  // What Chromium says of pictures that are read back is no fault.
  assert.deepEqual(said.filter(text => !text.includes('GPU stall due to ReadPixels')), [], `${one.name}: what is said and what fails`);
  await context.close();
  return { ...found, tiles: tiles.size };
}

// In the page: heights at the places, level by level, as Cesium.sampleTerrain looks them up in tiles.
async function lookUp({ name, promise, places }) {
  const { semi_major: a, semi_minor: b } = promise;
  Cesium.Ellipsoid.default = new Cesium.Ellipsoid(a, a, b);
  const options = { requestVertexNormals: true, ellipsoid: Cesium.Ellipsoid.default };
  window.provider = await Cesium.CesiumTerrainProvider.fromUrl(`/${name}`, options);
  const at = () => places.map(([lon, lat]) => Cesium.Cartographic.fromDegrees(lon, lat));
  const heights = all => all.map(place => place.height ?? null);
  const levels = [];
  for (const { level } of promise.levels) levels.push(heights(await Cesium.sampleTerrain(provider, level, at())));
  const mostDetailed = heights(await Cesium.sampleTerrainMostDetailed(provider, at()));
  const errors = promise.levels.map(({ level }) => provider.getLevelMaximumGeometricError(level));
  return { levels, mostDetailed, errors, hasNormals: provider.hasVertexNormals };
}

// In the page: a globe of the set without imagery, lit from the north-west, before a sky of magenta.
function setUp() {
  const { Color } = Cesium;
  const bare = { baseLayer: false, skyBox: false, skyAtmosphere: false, scene3DOnly: true };
  const contextOptions = { webgl: { preserveDrawingBuffer: true } };
  const creditContainer = document.createElement('div');
  window.widget = new Cesium.CesiumWidget('globe', { ...bare, terrainProvider: provider, contextOptions, creditContainer });
  const { scene } = widget;
  scene.backgroundColor = Color.MAGENTA;
  scene.fog.enabled = false;
  scene.sun = scene.moon = undefined;
  const still = { baseColor: new Color(0.8, 0.8, 0.75), enableLighting: true, showGroundAtmosphere: false };
  Object.assign(scene.globe, { ...still, dynamicAtmosphereLighting: false, depthTestAgainstTerrain: true });
}

// In the page: the raster aslant, from above, or so near that the finest tiles are drawn, once all tiles are there.
async function drawn({ bounds: [west, south, east, north], near, view }) {
  const { Cartesian3, Math: { toRadians } } = Cesium;
  const { scene, camera } = widget;
  const middle = Cartesian3.fromDegrees((west + east) / 2, (south + north) / 2, view === 'near' ? near.height : 0);
  const frame = Cesium.Transforms.eastNorthUpToFixedFrame(middle);
  const direction = Cesium.Matrix4.multiplyByPointAsVector(frame, new Cartesian3(1, -1, -1), new Cartesian3());
  scene.light = new Cesium.DirectionalLight({ direction });
  const size = Cartesian3.distance(Cartesian3.fromDegrees(west, south), Cartesian3.fromDegrees(east, north));
  const [heading, pitch, range] = { aslant: [30, -20, 1.1 * size], above: [0, -89.99, 1.6 * size], near: [0, -89.99, near.range] }[view];
  camera.lookAt(middle, new Cesium.HeadingPitchRange(toRadians(heading), toRadians(pitch), range));
  let still = 0;
  const isWhole = await new Promise(done => {
    const deadline = performance.now() + 120_000;
    scene.postRender.addEventListener(function look() {
      still = scene.globe.tilesLoaded ? still + 1 : 0;
      if (still < 10 && performance.now() < deadline) return;
      scene.postRender.removeEventListener(look);
      done(still >= 10);
    });
  });
  const copy = document.createElement('canvas');
  [copy.width, copy.height] = [scene.canvas.width, scene.canvas.height];
  const context = copy.getContext('2d');
  context.drawImage(scene.canvas, 0, 0);
  const { data } = context.getImageData(0, 0, copy.width, copy.height);
  const shades = new Array(256).fill(0);
  let sky = 0, horizon = copy.height, below = 0;
  for (let y = 0; y < copy.height; y += 1) {
    let inRow = 0;
    for (let i = 4 * y * copy.width; i < 4 * (y + 1) * copy.width; i += 4) {
      if (data[i] > 240 && data[i + 1] < 15 && data[i + 2] > 240) inRow += 1;
      else shades[data[i]] += 1;
    }
    sky += inRow;
    if (inRow === 0) horizon = Math.min(horizon, y);
    if (y > horizon) below += inRow;
  }
  const share = pixels => pixels / copy.width / copy.height;
  return { isWhole, sky: share(sky), cracks: share(below), shades: shades.filter(count => count > 20).length };
}

// In the page: heights at the places on the meshes that are drawn, and where the picture's depth puts the pixel of a place.
function pick({ places }) {
  const { scene, scene: { globe } } = widget;
  const { Cartographic, Cartesian3, Math: { toDegrees } } = Cesium;
  return places.map(([lon, lat]) => {
    const place = Cartographic.fromDegrees(lon, lat);
    const tile = globe._surface._tilesToRender.find(({ rectangle }) => Cesium.Rectangle.contains(rectangle, place));
    const height = globe.getHeight(place);
    if (!tile || height === undefined) return null;
    // From below, the first that a ray meets on a border is the skirt.
    const side = toDegrees(tile.rectangle.width);
    const isOnBorder = [(lon + 180) / side, (lat + 90) / side].some(at => Math.abs(at - Math.round(at)) < 1e-3);
    const { encoding } = tile.data.renderedMesh;
    const bits = encoding.quantization === Cesium.TerrainQuantization.BITS12 ? 12 : 32;
    const size = Cartesian3.magnitude(Cesium.Matrix4.getScale(encoding.fromScaledENU, new Cartesian3()));
    const pixel = scene.cartesianToCanvasCoordinates(Cartesian3.fromDegrees(lon, lat, height));
    const seen = pixel && scene.pickPosition(pixel);
    const at = seen && Cartographic.fromCartesian(seen);
    const depth = at && at.height - globe.getHeight(at);
    const { level } = tile;
    return { level, bits, size, height, isOnBorder, depth: depth ?? NaN };
  });
}

function check({ name, promise, places, near: { first, pixel } }, { levels, mostDetailed, errors, hasNormals, aslant, above, near, picked }) {
  assert(hasNormals, `${name}: normals`);
  promise.levels.forEach(({ level, max_error: allowed, client_error: expected }) => {
    assert(Math.abs(errors[level] - expected) < 1e-6 * expected, `${name}: CesiumJS's error of level ${level}: ${errors[level]}`);
    const off = largest(levels[level].map((height, i) => height === null ? NaN : height - places[i][2]));
    assert(off <= (1 + SAG) * allowed, `${name}: heights of level ${level} are off by ${off}`);
  });
  assert.deepEqual(mostDetailed, levels.at(-1), `${name}: most detailed`);
  assert(aslant.isWhole && above.isWhole && near.isWhole, `${name}: tiles are still loaded`);
  assert(aslant.sky > 0.01 && aslant.sky < 0.5, `${name}: ${aslant.sky} of the picture are sky`);
  // Where the ground runs down to the height outside, tiles of two levels may gape by more than skirts hide.
  assert(aslant.cracks < 1e-3, `${name}: ${aslant.cracks} of the picture are sky below the horizon`);
  assert(above.sky === 0 && near.sky === 0, `${name}: from above ${above.sky} of the picture are sky`);
  assert(Math.min(aslant.shades, above.shades) > 30, `${name}: ${aslant.shades} and ${above.shades} shades`);
  const seen = places.flatMap(([, , expected], i) => {
    const found = i < first ? null : picked[i];
    if (found?.level !== promise.levels.length - 1 || found.isOnBorder || Number.isNaN(found.depth)) return [];
    return [{ ...found, off: found.height - expected, lost: found.height - mostDetailed[i] }];
  });
  assert(seen.length > 0.9 * (places.length - first), `${name}: ${seen.length} places are on the finest tiles`);
  const allowed = promise.levels.at(-1).max_error;
  for (const { bits, height, off, lost, depth, size } of seen) {
    // The twelve bits are of a box around the tile with its skirts; as much again is lost sideways where the ground is steep.
    const rounding = bits === 12 ? size / 4096 : 0;
    assert(Math.abs(off) <= allowed + rounding, `${name}: getHeight gives ${height}, off by ${off}`);
    assert(Math.abs(lost) <= SAG * allowed + rounding, `${name}: getHeight and sampleTerrain differ by ${lost}`);
    // A pixel sees the ground somewhere under it.
    assert(Math.abs(depth) <= 2 * pixel, `${name}: the picture's depth is ${depth} m from the mesh`);
  }
  if (promise.fine_heights) assert(seen.every(({ bits }) => bits === 32), `${name}: floats`);
}

// NaN if one is.
function largest(numbers) {
  return numbers.reduce((most, number) => Math.max(most, Math.abs(number)), 0);
}

function table({ name, promise, places }, { levels, picked }) {
  return promise.levels.map(({ level, max_error: allowed }) => {
    const off = largest(levels[level].map((height, i) => height - places[i][2]));
    const seen = places.flatMap(([, , expected], i) => {
      const found = picked[i];
      if (found?.level !== level || found.isOnBorder) return [];
      return [{ off: found.height - expected, lost: found.height - levels[level][i], bits: found.bits }];
    });
    const most = of => seen.length ? largest(seen.map(of)).toFixed(3) : '–';
    const bits = [...new Set(seen.map(found => `${found.bits} bits`))].join(', ') || '–';
    return `| ${name} | ${level} | ${allowed.toFixed(3)} | ${off.toFixed(3)} | ${bits} | ${most(s => s.off)} | ${most(s => s.lost)} |`;
  });
}
