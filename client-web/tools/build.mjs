// Bundles the page into dist/: one script, one style sheet, no source of any other host. The parts of the page import
// their styles; these follow each other as the imports do. Names of both hold a hash of what is in them, so that browsers
// may keep them; each file has its compressed forms beside it.

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
  format: 'esm',
  target: 'es2021',
  minify: true,
  mangleProps: /[a-z]_$/, // private members, which nothing names from outside
  legalComments: 'none',
  metafile: true,
});
const outputs = Object.keys(metafile.outputs).map((path) => basename(path));
let page = await readFile(join(root, 'static/index.html'), 'utf8');
for (const [name, ending] of [
  ['app.js', '.js'],
  ['style.css', '.css'],
]) {
  const hashed = outputs.find((path) => path.endsWith(ending));
  if (hashed === undefined || !page.includes(`"${name}"`)) throw new Error(`${name}: not built, or not in index.html`);
  page = page.replace(`"${name}"`, `"${hashed}"`);
}
await writeFile(join(dist, 'index.html'), page);
await cp(join(root, 'static/favicon.svg'), join(dist, 'favicon.svg'));
for (const name of await readdir(dist)) {
  const bytes = await readFile(join(dist, name));
  await writeFile(join(dist, `${name}.gz`), gzipSync(bytes, { level: 9 }));
  await writeFile(join(dist, `${name}.br`), brotliCompressSync(bytes));
}
