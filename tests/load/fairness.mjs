// How much of its frame rate a viewer of a light scene keeps while another one looks at a heavy scene. Prints figures;
// nothing here passes or fails.
//
//   node tests/load/fairness.mjs [path of heliograph] [light scene] [heavy scene] [seconds] [rounds] [name=value settings...]
import { Server, Viewer, sleep, until } from './viewer.mjs';

const [program = 'build/release/heliograph', light = 'cornell', heavy = 'glass', seconds = '5', rounds = '3', ...settings] =
  process.argv.slice(2);
const INPUT_EVERY_MS = 10;
const LIGHT_SIZE = { width: 640, height: 360 };
const HEAVY_SIZE = { width: 1920, height: 1080 };
const values = Object.fromEntries(settings.map((text) => text.split('=')));

async function opened(url, scene, size) {
  const viewer = new Viewer(url, 0, size);
  await until(() => viewer.problem || viewer.scene, 'no scene');
  viewer.scene = null;
  viewer.send({ type: 'scene', name: scene });
  if (settings.length > 0) viewer.send({ type: 'settings', values, inputId: ++viewer.inputId });
  await until(() => viewer.problem || viewer.scene, `no scene ${scene}`);
  viewer.send({ type: 'resolution', ...size, inputId: ++viewer.inputId });
  await until(() => viewer.problem || viewer.frames > 0, 'no frame');
  if (viewer.problem) throw new Error(viewer.problem);
  return viewer;
}

/** Frames a second of each viewer while all of them look around. */
async function rates(viewers) {
  const begin = Date.now();
  const before = viewers.map((viewer) => viewer.frames);
  while (Date.now() - begin < 1000 * Number(seconds)) {
    for (const viewer of viewers) viewer.look(Date.now() - begin);
    await sleep(INPUT_EVERY_MS);
  }
  const elapsed = (Date.now() - begin) / 1000;
  return viewers.map((viewer, i) => (viewer.frames - before[i]) / elapsed);
}

const server = await Server.start(program, light);
try {
  await server.ready();
  const rows = [];
  for (let round = 0; round < Number(rounds); round++) {
    const first = await opened(server.url, light, LIGHT_SIZE);
    const [alone] = await rates([first]);
    const second = await opened(server.url, heavy, HEAVY_SIZE);
    const [beside, other] = await rates([first, second]);
    first.close();
    await sleep(500);
    const [heavyAlone] = await rates([second]);
    second.close();
    rows.push({ alone, beside, other, heavyAlone, kept: beside / alone });
    console.log(`${light} alone ${alone.toFixed(1)} /s, beside ${heavy} ${beside.toFixed(1)} /s (${((100 * beside) / alone).toFixed(0)} %); ` +
      `${heavy} alone ${heavyAlone.toFixed(1)} /s, beside ${other.toFixed(1)} /s`);
  }
  const kept = rows.map((row) => row.kept).sort((a, b) => a - b)[Math.floor(rows.length / 2)];
  console.log(`median kept: ${(100 * kept).toFixed(0)} %`);
} finally {
  await server.end();
}
process.exit(0);
