// What it costs when several watch one view: processor time of the server for one viewer and for one with watchers.
//
//   node tests/load/feel_watchers.mjs [--watchers 1,10] [--seconds 15] [--scene courtyard] [--inputs 3]
//
// The driver's hand gives so few inputs a second that all are rendered, at 1280x720 and full scale, one sample each. Encodings
// are those of the server's metrics. HELIOGRAPH_BINARY names another server; heliograph-load has to be built. It measures; it
// judges nothing.
import { spawnSync } from 'node:child_process';
import { readFileSync } from 'node:fs';
import { join } from 'node:path';
import { parseArgs } from 'node:util';

import { freePort, root, Server, until } from '../browser/page.mjs';

const { values: options } = parseArgs({
  options: {
    watchers: { type: 'string', default: '1,10' },
    seconds: { type: 'string', default: '15' },
    scene: { type: 'string', default: 'courtyard' },
    inputs: { type: 'string', default: '3' },
  },
});
const load = join(root, 'build/release/tests/heliograph-load');
const TICKS = 100; // a second, of /proc/PID/stat on Linux

/** Processor seconds of a process so far. */
function processorSeconds(pid) {
  const fields = readFileSync(`/proc/${pid}/stat`, 'utf8').split(') ')[1].split(' ');
  return (Number(fields[11]) + Number(fields[12])) / TICKS;
}

async function figures(port) {
  const text = await (await fetch(`http://127.0.0.1:${port}/metrics`)).text();
  const value = (name) => Number(text.split('\n').find((line) => line.startsWith(`${name} `))?.split(' ')[1] ?? NaN);
  const stage = (name, what) => value(`heliograph_frame_stage_seconds_${what}{stage="${name}"}`);
  return {
    sent: value('heliograph_frames_sent_total'),
    encodings: stage('encode', 'count'),
    seconds: stage('encode', 'sum') + stage('develop', 'sum'),
  };
}

async function measure(watchers) {
  const set = { HELIOGRAPH_SET: 'samples=1,automaticScale=false,adaptiveQuality=false,exactAtRest=false' };
  const server = new Server(await freePort(), options.scene, undefined, set);
  await server.start();
  try {
    const address = `ws://127.0.0.1:${server.port}/ws`;
    const run = (seconds, viewers, script) =>
      spawnSync(load, [address, '--viewers', viewers, '--script', script, '--seconds', seconds, '--size', '1280x720',
        '--inputs', options.inputs, '--json'].map(String), { encoding: 'utf8' });
    await until('the scene', 120_000, () => JSON.parse(run(1, 1, 'orbit').stdout || '{}').frames > 0);
    const before = [processorSeconds(server.process.pid), await figures(server.port)];
    const result = run(options.seconds, watchers + 1, watchers > 0 ? 'watch' : 'orbit');
    if (result.status !== 0) throw new Error(result.stderr);
    const after = [processorSeconds(server.process.pid), await figures(server.port)];
    const changed = (key) => after[1][key] - before[1][key];
    return { processor: after[0] - before[0], sent: changed('sent'), encodings: changed('encodings'), seconds: changed('seconds') };
  } finally {
    await server.kill();
  }
}

const perFrame = (r, watchers) => (1000 * r.processor * (watchers + 1)) / r.sent;
console.log('| watchers | pictures sent | encodings | ms to make one | processor ms a frame | of one viewer |');
console.log('| ---: | ---: | ---: | ---: | ---: | ---: |');
const alone = await measure(0);
for (const watchers of [0, ...options.watchers.split(',').map(Number)]) {
  const r = watchers === 0 ? alone : await measure(watchers);
  const cells = [watchers, r.sent, r.encodings, ((1000 * r.seconds) / r.encodings).toFixed(1), perFrame(r, watchers).toFixed(0),
    `${(perFrame(r, watchers) / perFrame(alone, 0)).toFixed(2)} x`];
  console.log(`| ${cells.join(' | ')} |`);
}
