// Bundles the page into dist/: one script, one style sheet, no source of any other host.

import { build } from 'esbuild';
import { cp, mkdir, rm } from 'node:fs/promises';
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
await build({ entryPoints: [join(root, 'static/style.css')], outfile: join(dist, 'style.css'), minify: true });
for (const name of ['index.html', 'favicon.svg']) await cp(join(root, 'static', name), join(dist, name));
