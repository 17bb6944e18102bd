// Bundles the page into dist/: one style sheet, one script, and others beside it for what is loaded when it is first asked
// for (`import()`); no source of any other host. The parts of the page import their styles; these follow each other as the
// imports do. All names hold a hash of what is in them, so that browsers may keep them; each file has its compressed forms
// beside it.

import { build } from 'esbuild';
import { cp, mkdir, readdir, readFile, rm, writeFile } from 'node:fs/promises';
import { basename, dirname, join } from 'node:path';
import { fileURLToPath } from 'node:url';
import { brotliCompressSync, gzipSync } from 'node:zlib';

const root = join(dirname(fileURLToPath(import.meta.url)), '..');
const dist = join(root, 'dist');

await rm(dist, { recursive: true, force: true });
await mkdir(dist, { recursive: true });
const { metafile } = await build({
  entryPoints: { app: join(root, 'src/main.ts') },
  outdir: dist,
  entryNames: '[name]-[hash]',
  bundle: true,
  splitting: true,
  chunkNames: '[name]-[hash]',
  format: 'esm',
  target: 'es2021',
  minify: true,
  mangleProps: /[a-z]_$/, // private members, which nothing names from outside
  legalComments: 'none',
  metafile: true,
});
const [script, { cssBundle, imports }] = Object.entries(metafile.outputs).find(([, { entryPoint }]) =>
  entryPoint?.endsWith('src/main.ts'),
);
let page = await readFile(join(root, 'static/index.html'), 'utf8');
for (const [name, built] of [
  ['app.js', script],
  ['style.css', cssBundle],
]) {
  if (built === undefined || !page.includes(`"${name}"`)) throw new Error(`${name}: not built, or not in index.html`);
  page = page.replace(`"${name}"`, `"${basename(built)}"`);
}
// What the script shares with later ones comes along with it, not after it.
const shared = imports.filter(({ kind }) => kind === 'import-statement');
const preloads = shared.map(({ path }) => `<link rel="modulepreload" href="${basename(path)}">\n    `).join('');
page = page.replace('<script type="module"', `${preloads}<script type="module"`);
await writeFile(join(dist, 'index.html'), page);
await cp(join(root, 'static/favicon.svg'), join(dist, 'favicon.svg'));
for (const name of await readdir(dist)) {
  const bytes = await readFile(join(dist, name));
  await writeFile(join(dist, `${name}.gz`), gzipSync(bytes, { level: 9 }));
  await writeFile(join(dist, `${name}.br`), brotliCompressSync(bytes));
}
