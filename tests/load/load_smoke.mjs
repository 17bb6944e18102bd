// A short load test: eight viewers of one server look around in `cornell` for five seconds. One of them acknowledges late.
// Every viewer must get whole frames, no error and, once it rests, a frame that shows its last input; the late one never
// has more frames under way than the server promised; the server stays well and ends when asked to.
//
//   node tests/load/load_smoke.mjs [path of heliograph]
//
// The last line is `N passed, N failed`; exit code 0 only if none failed. Waits end early when they can: the limits below
// only bound a server that does not answer.
import { Server, Viewer, sleep } from './viewer.mjs';

const VIEWERS = 8;
const MOVING_MS = 5000;
const INPUT_EVERY_MS = 50;
const LATE_ACK_MS = 150;
const SIZE = { width: 320, height: 180 };

let passed = 0;
let failed = 0;
function check(name, problem, note = '') {
  problem ? failed++ : passed++;
  console.log(`${problem ? 'not ok' : 'ok'} - ${name}${problem ? `: ${problem}` : ''}${note && ` (${note})`}`);
}

async function drive(url, viewers) {
  for (let i = 0; i < VIEWERS; i++) viewers.push(new Viewer(url, i === 0 ? LATE_ACK_MS : 0, SIZE));
  await Promise.all(viewers.map((viewer) => viewer.start().catch((error) => viewer.fail(error.message))));
  const begin = Date.now();
  while (Date.now() - begin < MOVING_MS) {
    for (const viewer of viewers) if (!viewer.problem) viewer.look(Date.now() - begin);
    await sleep(INPUT_EVERY_MS);
  }
  const moving = viewers.map((viewer) => viewer.frames);
  await Promise.all(viewers.map((viewer) => viewer.rest().catch((error) => viewer.fail(error.message))));
  for (const [i, viewer] of viewers.entries()) {
    const note = `${moving[i]} frames while moving, ${Math.round(viewer.bytes / 1024)} KiB in all`;
    check(`viewer ${i + 1} sees every frame whole and its last input`,
      viewer.problem || (moving[i] === 0 ? 'no frame while moving' : ''), note);
  }
  const promised = viewers[0].hello?.maxUnacked;
  const most = Math.max(...viewers.map((viewer) => viewer.mostUnacked));
  check('no viewer has more frames under way than promised', most <= promised ? '' : `${most} frames, promised ${promised}`);
  for (const viewer of viewers) viewer.close();
}

const program = process.argv[2] ?? 'build/release/heliograph';
const server = await Server.start(program, 'cornell');
try {
  await server.ready();
  await drive(server.url, []);
  check('the server is well afterwards',
    server.ended !== null ? `it ended with ${server.ended}` : (await server.healthy()) ? '' : 'no answer from /healthz');
  await server.end();
  check('the server ends when asked to',
    server.ended === 'exit code 0' || server.ended === 'SIGTERM' ? '' : `it ended with ${server.ended}`);
} catch (error) {
  check('the load test runs', error.message);
}
if (failed > 0) console.log(`what the server said:\n${server.output.slice(-4000)}`);
console.log(`${passed} passed, ${failed} failed`);
process.exit(failed === 0 && passed > 0 ? 0 : 1);
