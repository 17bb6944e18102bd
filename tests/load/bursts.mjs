// The last input of every burst is answered by a frame, and no frame shows an older input after a newer one: random bursts of
// camera messages over lines of different delay, rate and stalls, half of the viewers with a video, three busy ones beside.
//
//   node tests/load/bursts.mjs [--bursts 1000] [--program build/release/heliograph] [--seed 1]
//
// A row a line on stdout: bursts, missed, and how long after the last input its frame came. Exit code 1 where one was missed or
// anything was wrong.
import { parseArgs } from 'node:util';
import { Line, LINES } from './line.mjs';
import { Server, Viewer, sleep, until } from './viewer.mjs';

const PATIENCE = 20_000; // ms, for a machine that does much else
const VIEWERS = 4; // a line
const SIZE = { width: 160, height: 90 };

const { values: options } = parseArgs({
  options: {
    bursts: { type: 'string', default: '1000' },
    program: { type: 'string', default: 'build/release/heliograph' },
    seed: { type: 'string', default: '1' },
  },
});

/** Even in [0, 1), the same in every run. */
function randomOf(seed) {
  let state = seed;
  return () => (state = (state * 48271) % 2147483647) / 2147483647;
}

async function burst(viewer, random) {
  const inputs = 1 + Math.floor(random() * 20);
  const gap = random() < 0.3 ? 0 : random() * 40;
  for (let i = 0; i < inputs; i++) {
    viewer.look(random() * 6000, i + 1 < inputs || random() < 0.5);
    if (gap > 0) await sleep(gap);
  }
  const begin = performance.now();
  await until(() => viewer.problem || viewer.shownInputId === viewer.inputId, 'the last input of a burst was not answered',
    () => `(shown ${viewer.shownInputId}, sent ${viewer.inputId})`, PATIENCE);
  const delay = performance.now() - begin;
  if (viewer.problem) throw new Error(viewer.problem);
  await sleep(random() * 100);
  return delay;
}

async function run(server, name, bursts) {
  const line = await Line.open(server.port, LINES[name]);
  const [delays, faults] = [[], []];
  const one = async (index) => {
    const random = randomOf(Number(options.seed) * 977 + 31 * index + name.length);
    const viewer = new Viewer(`ws://127.0.0.1:${line.port}/ws`, 0, SIZE);
    try {
      await viewer.start();
      if (index % 2 === 1) viewer.video();
      for (let i = index; i < bursts; i += VIEWERS) delays.push(await burst(viewer, random));
    } catch (error) {
      faults.push(`viewer ${index}: ${error.message}`);
    }
    viewer.close();
    return viewer.videoFrames;
  };
  const videos = await Promise.all(Array.from({ length: VIEWERS }, (_, index) => one(index)));
  line.close();
  if (videos.reduce((sum, count) => sum + count, 0) === 0) faults.push('no frame was a video\u2019s');
  delays.sort((a, b) => a - b);
  const at = (share) => delays[Math.min(delays.length - 1, Math.floor(share * delays.length))]?.toFixed(0) ?? '\u2013';
  console.log(`| ${name} | ${bursts} | ${bursts - delays.length} | ${at(0.5)} | ${at(0.95)} | ${at(1)} |`);
  for (const fault of faults) console.log(`${name}: ${fault}`);
  return faults.length;
}

/** Three that never rest. */
async function busy(server) {
  const viewers = [0, 1, 2].map(() => new Viewer(server.url, 0, { width: 480, height: 270 }));
  await Promise.all(viewers.map((viewer) => viewer.start()));
  const begin = Date.now();
  const timer = setInterval(() => viewers.forEach((viewer) => viewer.look(Date.now() - begin)), 40);
  return () => {
    clearInterval(timer);
    viewers.forEach((viewer) => viewer.close());
    return viewers.find((viewer) => viewer.problem)?.problem ?? '';
  };
}

const server = await Server.start(options.program, 'cornell');
let faults = 0;
try {
  await server.ready();
  const rest = await busy(server);
  const names = Object.keys(LINES);
  const each = Math.ceil(Number(options.bursts) / names.length);
  console.log('| line | bursts | missed | answered after p50 ms | p95 | most |\n| --- | ---: | ---: | ---: | ---: | ---: |');
  for (const counts of await Promise.all(names.map((name) => run(server, name, each)))) faults += counts;
  const problem = rest();
  if (problem) console.log(`a busy viewer: ${problem}`), faults++;
} finally {
  await server.end();
}
process.exit(faults > 0 ? 1 : 0);
