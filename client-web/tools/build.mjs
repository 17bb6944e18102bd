// Bundles the page into dist/: one script, one style sheet, no source of any other host. The parts of the page import
// their styles; these follow each other as the imports do.

import { build } from 'esbuild';
import { cp, mkdir, rename, rm } from 'node:fs/promises';
import { dirname, join } from 'node:path';
import { fileURLToPath } from 'node:url';

const root = join(dirname(fileURLToPath(import.meta.url)), '..');
const dist = join(root, 'dist');

await rm(dist, { recursive: true, force: true });
await mkdir(dist, { recursive: true });
await build({
  entryPoints: [join(root, 'src/main.ts')],
  outfile: join(dist, 'app.js'),
  bundle: true,
  format: 'esm',
  target: 'es2021',
  minify: true,
  legalComments: 'none',
});
await rename(join(dist, 'app.css'), join(dist, 'style.css'));
for (const name of ['index.html', 'favicon.svg']) await cp(join(root, 'static', name), join(dist, name));
