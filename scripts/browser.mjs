// Opens pages in headless Chromium and checks what is there; called by browser_tests.py.

import assert from 'node:assert/strict';
import { spawn } from 'node:child_process';
import { once } from 'node:events';
import { createRequire } from 'node:module';
import { basename } from 'node:path';
import { readFileSync, statSync } from 'node:fs';
import { checkView } from './browser_view.mjs';

const { NODE_MODULES, CHROMIUM, OUT, TERRABITE } = process.env;
const { chromium } = createRequire(`${NODE_MODULES}/`)('playwright-core');
const files = process.argv.slice(2);
// Without a graphics card WebGL is drawn by the processor.
const args = ['--no-sandbox', '--use-angle=swiftshader', '--enable-unsafe-swiftshader'];
const browser = await chromium.launch({ executablePath: CHROMIUM, args });
const mesh = JSON.parse(readFileSync(`${OUT}/tin.json`, 'utf8'));

for (const file of files) {
  const name = basename(file, '.html');
  assert(statSync(file).size < 3e6, `${file}: at most 3 MB`);
  for (const scheme of ['light', 'dark']) {
    await opened(name, `file://${file}`, scheme, async page => {
      await page.screenshot({ path: `${OUT}/${name}-${scheme}.png`, fullPage: true });
      check(name, scheme, await page.evaluate(look));
      if (scheme === 'dark') return;
      await page.pdf({ path: `${OUT}/${name}.pdf`, format: 'A4' });
      await page.emulateMedia({ media: 'print' });
      await page.screenshot({ path: `${OUT}/${name}-print.png`, fullPage: true });
      await page.emulateMedia({ media: null });
      await checkView(page, name, name === 'large' ? undefined : mesh, OUT);
    });
  }
  const plain = await browser.newContext({ javaScriptEnabled: false });
  const page = await plain.newPage();
  await page.goto(`file://${file}`);
  assert.match(await page.locator('.verdict').innerText(), /^(PASS|FAIL)/);
  assert.match(await page.locator('noscript').innerText(), /needs JavaScript/);
  await plain.close();
  console.log(`${name}: as it should be`);
}
await served();
await browser.close();

// A page in a browser of this scheme, which says nothing on the console and asks for nothing but itself.
async function opened(name, address, scheme, use) {
  const context = await browser.newContext({ colorScheme: scheme, viewport: { width: 1200, height: 900 } });
  const page = await context.newPage();
  const said = [], requested = [];
  page.on('console', message => said.push(message.text()));
  page.on('pageerror', error => said.push(error.message));
  page.on('request', request => requested.push(request.url()));
  page.on('requestfailed', request => said.push(`failed: ${request.url().slice(0, 200)}`));
  await page.goto(address);
  await page.waitForSelector('#view[data-state]', { timeout: 60000 });
  assert.equal(await page.getAttribute('#view', 'data-state'), 'drawn', `${name}: ${await page.locator('.readout').innerText()} ${said}`);
  await use(page);
  assert.deepEqual(said, [], `${name}: what is on the console`);
  assert.deepEqual(requested.filter(url => !url.startsWith('data:')), [address], `${name}: requests`);
  await context.close();
}

// `terrabite view`: the same page from this machine, and nothing else.
async function served() {
  const process = spawn(TERRABITE, ['view', `${OUT}/tin.ply`, '--no-open'], { stdio: ['ignore', 'pipe', 'pipe'] });
  const ended = once(process, 'exit');
  const [first] = await once(process.stdout, 'data');
  const address = first.toString().trim();
  assert.match(address, /^http:\/\/127\.0\.0\.1:\d+\/[0-9a-f]{16}\/$/);
  await opened('view', address, 'light', async page => {
    await page.screenshot({ path: `${OUT}/view-light.png`, fullPage: true });
    await checkView(page, 'view', mesh, OUT);
  });
  const { origin } = new URL(address);
  for (const path of ['/', '/favicon.ico', '/tin.ply', '/../tin.ply', `${new URL(address).pathname}x`]) {
    assert.equal((await fetch(origin + path)).status, 404, path);
  }
  process.kill('SIGINT');
  assert.deepEqual(await ended, [0, null], 'Ctrl-C ends it');
  console.log('view: as it should be');
}

// In the page: what a reader sees of it.
function look() {
  const json = id => JSON.parse(document.getElementById(id).textContent);
  const rows = Object.fromEntries([...document.querySelectorAll('th[scope=row]')].map(th => [th.textContent, th.nextElementSibling.innerText]));
  const background = getComputedStyle(document.body).backgroundColor;
  const images = [...document.querySelectorAll('svg image')].map(image => image.getBoundingClientRect().width);
  const wide = document.documentElement.scrollWidth > document.documentElement.clientWidth;
  const outside = [...document.querySelectorAll('svg.chart text, svg text')].filter(text => {
    const [own, svg] = [text.getBoundingClientRect(), text.ownerSVGElement.getBoundingClientRect()];
    return own.left < svg.left - 1 || own.right > svg.right + 1 || own.bottom > svg.bottom + 1;
  }).map(text => text.textContent);
  return { report: json('report'), shown: json('view-settings'), rows, background, images, wide, outside,
    caption: document.getElementById('view').parentElement.innerText, verdict: document.querySelector('.verdict').innerText,
    bars: document.querySelectorAll('svg rect').length, faults: document.querySelectorAll('.bad').length };
}

function check(name, scheme, { report, shown, rows, background, images, wide, outside, caption, verdict, bars, faults }) {
  const light = background.match(/\d+/g).slice(0, 3).reduce((sum, part) => sum + Number(part), 0) > 384;
  assert.equal(light, scheme === 'light', `${name}: ${background} in ${scheme}`);
  assert(!wide, `${name}: no scrolling to the side`);
  assert.deepEqual(outside, [], `${name}: words that are cut off`);
  const digits = text => Number(text.match(/^[\d\s]+/)[0].replace(/\D/g, ''));
  assert.equal(digits(rows['Triangles']), report.triangles);
  assert.equal(digits(rows['Vertices']), report.vertices);
  assert.equal(digits(rows['Samples of the raster']), report.raster_samples);
  const isMade = 'error' in report;
  const largest = isMade ? report.error.max : report.worst.error;
  assert.equal(parseFloat(rows['Largest error']), largest);
  assert(bars > 20, `${name}: ${bars} bars`);
  assert.equal(shown.of, report.triangles);
  const numbers = [...caption.matchAll(/\d[\d\s]*(?=[ ’']|\.)/g)].map(found => digits(found[0]));
  assert(numbers.includes(shown.triangles) && numbers.includes(report.triangles), `${name}: ${caption}`);
  assert.equal(caption.includes('Not certified'), name === 'large', `${name}: ${caption}`);
  assert.equal(shown.isCopy, name === 'large');
  assert.equal(shown.drapes.length, isMade ? 0 : 3);
  if (isMade) return assert.match(verdict, /^PASS/);
  assert.equal(images.length, 4, `${name}: a hillshade and three maps`);
  assert(images.every(width => width > 100), `${name}: ${images}`);
  assert.equal(verdict.startsWith('PASS'), report.passed);
  assert.equal(report.passed, name !== 'failed');
  assert.equal(faults > 0, !report.passed);
  if (name === 'passed') assert.equal(report.checkpoints.off_mesh, 1);
}
