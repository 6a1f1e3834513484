// Bundles the view: dist/view.js, and dist/sums.txt with the SHA-256 of the bundle and of all that it is made from.
//
//   npm ci --ignore-scripts && node build.mjs [FOLDER]

import { createHash } from 'node:crypto';
import { mkdirSync, readFileSync, readdirSync, writeFileSync } from 'node:fs';
import { dirname, join } from 'node:path';
import { fileURLToPath } from 'node:url';
import { build } from 'esbuild';

const here = dirname(fileURLToPath(import.meta.url));
const out = process.argv[2] ?? join(here, 'dist');
const licence = (name, file) => {
  const version = JSON.parse(readFileSync(join(here, 'node_modules', name, 'package.json'), 'utf8')).version;
  return `${name} ${version}\n\n${readFileSync(join(here, 'node_modules', name, file), 'utf8').trim()}`;
};
const licences = [licence('three', 'LICENSE'), licence('meshoptimizer', 'LICENSE.md')].join('\n\n');
const made = await build({
  entryPoints: [join(here, 'src', 'view.js')],
  absWorkingDir: here,
  bundle: true,
  // The package has it, but does not export it.
  alias: { 'meshoptimizer/reference': join(here, 'node_modules', 'meshoptimizer', 'meshopt_decoder_reference.js') },
  minify: true,
  // A page runs it as a module: "await" stands at its top.
  format: 'esm',
  target: 'es2022',
  legalComments: 'none',
  charset: 'ascii',
  banner: { js: `/*\nThe view of terrabite's pages, with\n\n${licences}\n*/` },
  write: false,
});
const bundle = made.outputFiles[0].text;
if (/<\/script|<!--/i.test(bundle)) throw new Error('the bundle would end the element of the page that holds it');
mkdirSync(out, { recursive: true });
writeFileSync(join(out, 'view.js'), bundle);
const sum = bytes => createHash('sha256').update(bytes).digest('hex');
const sources = ['build.mjs', 'package-lock.json', 'package.json', ...readdirSync(join(here, 'src')).sort().map(name => `src/${name}`)];
const lines = sources.map(name => `${sum(readFileSync(join(here, name)))}  ${name}`);
writeFileSync(join(out, 'sums.txt'), `${[...lines, `${sum(bundle)}  dist/view.js`].join('\n')}\n`);
