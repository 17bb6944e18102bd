// A short load test: eight viewers of one server look around in `cornell` for five seconds. One of them acknowledges late.
// Every viewer must get whole frames, no error and, once it rests, a frame that shows its last input; the late one never
// has more frames under way than the server promised; the server stays well and ends when asked to.
//
//   node tests/load/load_smoke.mjs [path of heliograph]
//
// The last line is `N passed, N failed`; exit code 0 only if none failed. Waits end early when they can: the limits below
// only bound a server that does not answer.
import { spawn } from 'node:child_process';
import { createRequire } from 'node:module';
import { createServer } from 'node:net';

const WebSocket = createRequire(new URL('../../client-web/package.json', import.meta.url))('ws');

const VIEWERS = 8;
const MOVING_MS = 5000;
const INPUT_EVERY_MS = 50;
const PATIENCE_MS = 30000;
const LATE_ACK_MS = 150;
const SIZE = { width: 320, height: 180 };
const HEADER_BYTES = 64;

const sleep = (ms) => new Promise((resolve) => setTimeout(resolve, ms));

/** Waits until `condition` holds; throws `what` with what `state` says when patience ends. */
async function until(condition, what, state = () => '', patience = PATIENCE_MS) {
  const end = Date.now() + patience;
  while (!(await condition())) {
    if (Date.now() > end) throw new Error(`${what} within ${patience / 1000} s ${state()}`.trim());
    await sleep(20);
  }
}

function freePort() {
  return new Promise((resolve, reject) => {
    const probe = createServer();
    probe.on('error', reject);
    probe.listen(0, '127.0.0.1', () => {
      const { port } = probe.address();
      probe.close(() => resolve(port));
    });
  });
}

/** The 64-byte header of docs/protocol.md; throws when the message is not a whole frame. */
function readFrame(data) {
  if (data.length < HEADER_BYTES) throw new Error(`a binary message of ${data.length} bytes, less than a header`);
  const magic = data.toString('latin1', 0, 2);
  if (magic !== 'HG') throw new Error(`magic "${magic}" instead of "HG"`);
  const headerBytes = data.readUInt16LE(4);
  const frame = {
    kind: data[2], codec: data[3], id: data.readUInt32LE(8), inputId: data.readUInt32LE(12),
    width: data.readUInt16LE(24), height: data.readUInt16LE(26), payload: data.readUInt32LE(56),
  };
  if (headerBytes + frame.payload !== data.length)
    throw new Error(`header ${headerBytes} + payload ${frame.payload} bytes, but the message has ${data.length}`);
  if (frame.width !== SIZE.width || frame.height !== SIZE.height) throw new Error(`a frame for ${frame.width}x${frame.height}`);
  if (frame.codec === 0 && data.readUInt16BE(headerBytes) !== 0xffd8) throw new Error('the payload is no JPEG');
  return frame;
}

class Viewer {
  constructor(url, ackDelay) {
    this.ackDelay = ackDelay;
    this.frames = 0;
    this.bytes = 0;
    this.unacked = 0;
    this.mostUnacked = 0;
    this.inputId = 0;
    this.shownInputId = 0;
    this.lastFrameId = -1;
    this.problem = '';
    this.closing = false;
    this.socket = new WebSocket(url, 'heliograph.v1');
    this.socket.on('message', (data, binary) => {
      try {
        binary ? this.takeFrame(data) : this.takeMessage(JSON.parse(data));
      } catch (error) {
        this.fail(error.message);
      }
    });
    this.socket.on('error', (error) => this.fail(`socket: ${error.message}`));
    this.socket.on('close', (code) => this.closing || this.fail(`the server closed the connection with code ${code}`));
  }

  fail(text) { this.problem ||= text; }
  send(message) { this.socket.send(JSON.stringify(message)); }

  takeMessage(message) {
    if (message.type === 'hello') this.hello = message;
    if (message.type === 'scene' && message.state === 'failed') this.fail(`scene failed: ${message.what}`);
    if (message.type === 'scene' && message.state === 'ready') this.scene = message;
    if (message.type === 'error') this.fail(`error message: ${message.message}`);
  }

  takeFrame(data) {
    const frame = readFrame(data);
    if (frame.id <= this.lastFrameId) this.fail(`frame ${frame.id} came after frame ${this.lastFrameId}`);
    if (frame.inputId < this.shownInputId) this.fail(`input ${frame.inputId} shown after input ${this.shownInputId}`);
    this.lastFrameId = frame.id;
    this.shownInputId = frame.inputId;
    this.frames++;
    this.bytes += data.length;
    this.unacked++;
    this.mostUnacked = Math.max(this.mostUnacked, this.unacked);
    setTimeout(() => {
      if (this.socket.readyState !== WebSocket.OPEN) return;
      this.unacked--;
      this.send({ type: 'ack', frameId: frame.id, presentedMs: null });
    }, this.ackDelay);
  }

  async start() {
    await until(() => this.problem || (this.hello && this.scene), 'no hello and scene');
    if (!this.problem) this.send({ type: 'resolution', ...SIZE, inputId: ++this.inputId });
  }

  /** Turns the head: a full circle in 6 s around the vertical axis. */
  look(ms) {
    const { position, forward, up, fieldOfView } = this.scene.camera;
    const angle = (ms / 6000) * 2 * Math.PI;
    const turn = ([x, y, z]) => [x * Math.cos(angle) + z * Math.sin(angle), y, z * Math.cos(angle) - x * Math.sin(angle)];
    const message = { position, forward: turn(forward), up: turn(up), fieldOfView, moving: true };
    this.send({ type: 'camera', inputId: ++this.inputId, ...message });
  }

  async rest() {
    await until(() => this.problem || this.shownInputId === this.inputId, 'the last input was not shown',
      () => `(shown ${this.shownInputId}, sent ${this.inputId})`);
  }

  close() {
    this.closing = true;
    this.socket.close();
  }
}

let passed = 0;
let failed = 0;
function check(name, problem, note = '') {
  problem ? failed++ : passed++;
  console.log(`${problem ? 'not ok' : 'ok'} - ${name}${problem ? `: ${problem}` : ''}${note && ` (${note})`}`);
}

async function drive(url, viewers) {
  for (let i = 0; i < VIEWERS; i++) viewers.push(new Viewer(url, i === 0 ? LATE_ACK_MS : 0));
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
const port = await freePort();
const base = `127.0.0.1:${port}`;
const server = spawn(program, ['serve', 'cornell', '--listen', base], { stdio: ['ignore', 'pipe', 'pipe'] });
let output = '';
let ended = null;
server.stdout.on('data', (text) => (output += text));
server.stderr.on('data', (text) => (output += text));
server.on('error', (error) => (ended = error.message));
server.on('exit', (code, signal) => (ended = signal ?? `exit code ${code}`));
process.on('exit', () => ended === null && server.kill('SIGKILL'));

const healthy = async () => {
  try {
    return (await fetch(`http://${base}/healthz`, { signal: AbortSignal.timeout(5000) })).ok;
  } catch {
    return false;
  }
};
try {
  await until(async () => ended !== null || (await healthy()), 'the server did not answer');
  if (ended !== null) throw new Error(`the server ended with ${ended}`);
  await drive(`ws://${base}/ws`, []);
  check('the server is well afterwards', ended !== null ? `it ended with ${ended}` : (await healthy()) ? '' : 'no answer from /healthz');
  server.kill('SIGTERM');
  await until(() => ended !== null, 'the server did not end after SIGTERM', () => '', 10000);
  check('the server ends when asked to', ended === 'exit code 0' || ended === 'SIGTERM' ? '' : `it ended with ${ended}`);
} catch (error) {
  check('the load test runs', error.message);
}
if (failed > 0) console.log(`what the server said:\n${output.slice(-4000)}`);
console.log(`${passed} passed, ${failed} failed`);
process.exit(failed === 0 && passed > 0 ? 0 : 1);
