// Opens pages in headless Chromium and checks what is there; called by browser_tests.py.

import assert from 'node:assert/strict';
import { createRequire } from 'node:module';
import { basename } from 'node:path';
import { statSync } from 'node:fs';

const { NODE_MODULES, CHROMIUM, OUT } = process.env;
const { chromium } = createRequire(`${NODE_MODULES}/`)('playwright-core');
const files = process.argv.slice(2);
const browser = await chromium.launch({ executablePath: CHROMIUM, args: ['--no-sandbox'] });

for (const file of files) {
  const name = basename(file, '.html');
  assert(statSync(file).size < 3e6, `${file}: at most 3 MB`);
  for (const scheme of ['light', 'dark']) {
    // Without JavaScript: a page has to do without.
    const context = await browser.newContext({ colorScheme: scheme, viewport: { width: 1200, height: 900 } });
    const page = await context.newPage();
    const said = [], requested = [];
    page.on('console', message => said.push(message.text()));
    page.on('pageerror', error => said.push(error.message));
    page.on('request', request => requested.push(request.url()));
    await page.goto(`file://${file}`);
    await page.screenshot({ path: `${OUT}/${name}-${scheme}.png`, fullPage: true });
    const found = await page.evaluate(look);
    assert.deepEqual(said, [], `${name}: what is on the console`);
    const others = requested.filter(url => !url.startsWith('file://') && !url.startsWith('data:'));
    assert.deepEqual([requested.filter(url => url.startsWith('file://')).length, others], [1, []], `${name}: requests`);
    check(name, scheme, found);
    if (scheme === 'light') await page.pdf({ path: `${OUT}/${name}.pdf`, format: 'A4' });
    await context.close();
  }
  const plain = await browser.newContext({ javaScriptEnabled: false });
  const page = await plain.newPage();
  await page.goto(`file://${file}`);
  assert.match(await page.locator('.verdict').innerText(), /^(PASS|FAIL)/);
  await plain.close();
  console.log(`${name}: as it should be`);
}
await browser.close();

// In the page: what a reader sees of it.
function look() {
  const report = JSON.parse(document.getElementById('report').textContent);
  const rows = Object.fromEntries([...document.querySelectorAll('th[scope=row]')].map(th => [th.textContent, th.nextElementSibling.innerText]));
  const background = getComputedStyle(document.body).backgroundColor;
  const images = [...document.querySelectorAll('svg image')].map(image => image.getBoundingClientRect().width);
  const wide = document.documentElement.scrollWidth > document.documentElement.clientWidth;
  const outside = [...document.querySelectorAll('svg.chart text, svg text')].filter(text => {
    const [own, svg] = [text.getBoundingClientRect(), text.ownerSVGElement.getBoundingClientRect()];
    return own.left < svg.left - 1 || own.right > svg.right + 1 || own.bottom > svg.bottom + 1;
  }).map(text => text.textContent);
  return { report, rows, background, images, wide, outside, verdict: document.querySelector('.verdict').innerText,
    bars: document.querySelectorAll('svg rect').length, faults: document.querySelectorAll('.bad').length };
}

function check(name, scheme, { report, rows, background, images, wide, outside, verdict, bars, faults }) {
  const light = background.match(/\d+/g).slice(0, 3).reduce((sum, part) => sum + Number(part), 0) > 384;
  assert.equal(light, scheme === 'light', `${name}: ${background} in ${scheme}`);
  assert(!wide, `${name}: no scrolling to the side`);
  assert.deepEqual(outside, [], `${name}: words that are cut off`);
  const digits = text => Number(text.match(/^[\d\s]+/)[0].replace(/\D/g, ''));
  assert.equal(digits(rows['Triangles']), report.triangles);
  assert.equal(digits(rows['Vertices']), report.vertices);
  assert.equal(digits(rows['Samples of the raster']), report.raster_samples);
  const largest = name === 'made' ? report.error.max : report.worst.error;
  assert.equal(parseFloat(rows['Largest error']), largest);
  assert(bars > 20, `${name}: ${bars} bars`);
  if (name === 'made') return assert.match(verdict, /^PASS/);
  assert.equal(images.length, 4, `${name}: a hillshade and three maps`);
  assert(images.every(width => width > 100), `${name}: ${images}`);
  assert.equal(verdict.startsWith('PASS'), report.passed);
  assert.equal(report.passed, name === 'passed');
  assert.equal(faults > 0, !report.passed);
  if (name === 'passed') assert.equal(report.checkpoints.off_mesh, 1);
}
