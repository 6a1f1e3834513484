// Uses the view of a page as a reader would, and looks at pixels and at what it says; called by browser.mjs.

import assert from 'node:assert/strict';

// `mesh` is what is shown, with vertices and triangles; without it, heights are not held against anything.
export async function checkView(page, name, mesh, out) {
  const canvas = page.locator('#view canvas');
  await canvas.scrollIntoViewIfNeeded();
  const control = control => page.locator(`#view [name=${control}]`);
  const { width, height } = await canvas.boundingBox();
  const begin = await pixels(page);
  const share = drawn(begin) / (begin.length / 4);
  assert(share > 0.15 && share < 0.95, `${name}: ${share} of the canvas is drawn on`);

  await control('edges').check();
  const edges = await pixels(page);
  assert(changed(begin, edges) > 0.02 * drawn(begin), `${name}: edges change ${changed(begin, edges)} pixels`);
  assert(Math.abs(drawn(edges) - drawn(begin)) < 0.03 * drawn(begin), `${name}: edges lie on the surface`);
  await canvas.screenshot({ path: `${out}/${name}-edges.png` });
  await control('edges').uncheck();
  assert.equal(changed(begin, await pixels(page)), 0, `${name}: without edges it is as before`);

  const usual = await control('factor').inputValue();
  await control('factor').fill(await control('factor').getAttribute('max'));
  assert.match(await page.locator('#view output').innerText(), /^× \d/);
  assert(changed(begin, await pixels(page)) > 0.2 * drawn(begin), `${name}: heights times more look otherwise`);
  await control('factor').fill(usual);
  assert.equal(changed(begin, await pixels(page)), 0, `${name}: as high as before, it looks as before`);

  for (const colours of await control('colours').locator('option').evaluateAll(all => all.map(option => option.value))) {
    if (colours === 'heights') continue;
    await control('colours').selectOption(colours);
    await page.waitForFunction(wanted => document.getElementById('view').dataset.colours === wanted, colours);
    assert(changed(begin, await pixels(page)) > 0.3 * drawn(begin), `${name}: ${colours} have colours of their own`);
    await canvas.screenshot({ path: `${out}/${name}-${colours}.png` });
  }
  await control('colours').selectOption('heights');
  await page.waitForFunction(() => document.getElementById('view').dataset.colours === 'heights');

  await page.mouse.move(...(await at(canvas, 0.5, 0.5)));
  await page.mouse.down();
  await page.mouse.move(...(await at(canvas, 0.7, 0.45)), { steps: 5 });
  await page.mouse.up();
  assert(changed(begin, await pixels(page)) > 0.2 * drawn(begin), `${name}: dragging turns it`);
  await control('reset').click();
  assert.equal(changed(begin, await pixels(page)), 0, `${name}: reset brings it back`);

  await control('above').click();
  if (mesh) await checkPlaces(page, name, canvas, mesh, width / height);
  await control('reset').click();
}

// Seen from above, what is said of a place is where the mesh is, and how high.
async function checkPlaces(page, name, canvas, mesh, aspect) {
  const bound = axis => mesh.vertices.map(vertex => vertex[axis]).reduce(([low, high], v) => [Math.min(low, v), Math.max(high, v)], [Infinity, -Infinity]);
  const [[left, right], [bottom, top]] = [bound(0), bound(1)];
  const span = Math.max(right - left, top - bottom);
  const found = [];
  for (const [across, down] of [[0.5, 0.5], [0.45, 0.4], [0.57, 0.62], [0.41, 0.55], [0.6, 0.35]]) {
    await page.mouse.move(...(await at(canvas, across, down)));
    await page.waitForTimeout(60);
    const said = await page.locator('#view .readout').innerText();
    const match = said.match(/^x (-?[\d.]+), y (-?[\d.]+), height (-?[\d.]+)/);
    if (!match) continue;
    const [x, y, height] = match.slice(1).map(Number);
    const expected = heightAt(mesh, x, y);
    assert(Math.abs(height - expected) < 0.05, `${name}: at ${x} ${y} the mesh is ${expected} high, said is ${said}`);
    found.push({ across: (across - 0.5) * aspect, down: down - 0.5, x, y });
  }
  assert(found.length >= 4, `${name}: ${found.length} of 5 places are on the mesh`);
  const middle = found[0];
  // What is higher is nearer and looks larger, by a few hundredths.
  assert(Math.abs(middle.x - (left + right) / 2) < 0.02 * span && Math.abs(middle.y - (bottom + top) / 2) < 0.02 * span,
    `${name}: in the middle of the canvas is ${middle.x} ${middle.y}`);
  const scale = found.slice(1).flatMap(place => [(place.x - middle.x) / place.across, (place.y - middle.y) / -place.down]);
  assert(Math.min(...scale) > 0 && Math.max(...scale) < 1.25 * Math.min(...scale), `${name}: north is up, and one scale both ways: ${scale}`);
}

const at = async (canvas, across, down) => {
  const { x, y, width, height } = await canvas.boundingBox();
  return [x + across * width, y + down * height];
};

// What the canvas shows: red, green, blue and opacity of each pixel.
async function pixels(page) {
  const text = await page.evaluate(() => {
    const view = document.querySelector('#view canvas');
    const copy = new OffscreenCanvas(view.width, view.height).getContext('2d', { willReadFrequently: true });
    copy.drawImage(view, 0, 0);
    const { data } = copy.getImageData(0, 0, view.width, view.height);
    let text = '';
    for (let i = 0; i < data.length; i += 1 << 15) text += String.fromCharCode(...data.subarray(i, i + (1 << 15)));
    return btoa(text);
  });
  return Buffer.from(text, 'base64');
}

const drawn = pixels => pixels.filter((value, i) => i % 4 === 3 && value > 0).length;

function changed(before, after) {
  let count = 0;
  for (let i = 0; i < before.length; i += 4) if (before.compare(after, i, i + 4, i, i + 4) !== 0) count++;
  return count;
}

// The height of the mesh at a place; NaN beside it.
function heightAt({ vertices, triangles }, x, y) {
  for (const [a, b, c] of triangles.map(triangle => triangle.map(vertex => vertices[vertex]))) {
    const area = (p, q, r) => (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]);
    const place = [x, y], whole = area(a, b, c);
    const shares = [area(place, b, c), area(a, place, c), area(a, b, place)].map(part => part / whole);
    // The place is rounded: it may be said to be just beside.
    if (shares.every(share => share >= -0.01)) return shares.reduce((sum, share, i) => sum + share * [a, b, c][i][2], 0);
  }
  return NaN;
}
