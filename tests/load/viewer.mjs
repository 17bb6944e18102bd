// What the load tests share: a viewer without a page, and a server of their own.
import { spawn } from 'node:child_process';
import { createRequire } from 'node:module';
import { createServer } from 'node:net';

const WebSocket = createRequire(new URL('../../client-web/package.json', import.meta.url))('ws');

const PATIENCE_MS = 30000;
const HEADER_BYTES = 64;

export const sleep = (ms) => new Promise((resolve) => setTimeout(resolve, ms));

/** Waits until `condition` holds; throws `what` with what `state` says when patience ends. */
export async function until(condition, what, state = () => '', patience = PATIENCE_MS) {
  const end = Date.now() + patience;
  while (!(await condition())) {
    if (Date.now() > end) throw new Error(`${what} within ${patience / 1000} s ${state()}`.trim());
    await sleep(20);
  }
}

export function freePort() {
  return new Promise((resolve, reject) => {
    const probe = createServer();
    probe.on('error', reject);
    probe.listen(0, '127.0.0.1', () => {
      const { port } = probe.address();
      probe.close(() => resolve(port));
    });
  });
}

/** The 64-byte header of docs/reference/protocol.md; throws when the message is not a whole frame. */
function readFrame(data, size) {
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
  if (frame.width !== size.width || frame.height !== size.height) throw new Error(`a frame for ${frame.width}x${frame.height}`);
  if (frame.codec === 0 && data.readUInt16BE(headerBytes) !== 0xffd8) throw new Error('the payload is no JPEG');
  return frame;
}

export class Viewer {
  constructor(url, ackDelay, size) {
    this.size = size;
    this.ackDelay = ackDelay;
    this.frames = 0;
    this.videoFrames = 0;
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
    const frame = readFrame(data, this.size);
    if (frame.id <= this.lastFrameId) this.fail(`frame ${frame.id} came after frame ${this.lastFrameId}`);
    if (frame.inputId < this.shownInputId) this.fail(`input ${frame.inputId} shown after input ${this.shownInputId}`);
    this.lastFrameId = frame.id;
    this.shownInputId = frame.inputId;
    this.frames++;
    if (frame.codec === 3) this.videoFrames++;
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
    if (!this.problem) this.send({ type: 'resolution', ...this.size, inputId: ++this.inputId });
  }

  /** Turns the head: a full circle in 6 s around the vertical axis. */
  look(ms, moving = true) {
    const { position, forward, up, fieldOfView } = this.scene.camera;
    const angle = (ms / 6000) * 2 * Math.PI;
    const turn = ([x, y, z]) => [x * Math.cos(angle) + z * Math.sin(angle), y, z * Math.cos(angle) - x * Math.sin(angle)];
    const message = { position, forward: turn(forward), up: turn(up), fieldOfView, moving };
    this.send({ type: 'camera', inputId: ++this.inputId, ...message });
  }

  /** Asks for a video. Its pictures are counted, not decoded. */
  video() {
    this.send({ type: 'client', vp9: true });
    this.send({ type: 'settings', inputId: ++this.inputId, values: { codec: 'vp9' } });
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

/** A server on a free port; `ended` says how it ended, or null. */
export class Server {
  static async start(program, scene) {
    const server = new Server();
    server.base = `127.0.0.1:${await freePort()}`;
    server.output = '';
    server.ended = null;
    server.child = spawn(program, ['serve', scene, '--listen', server.base], { stdio: ['ignore', 'pipe', 'pipe'] });
    server.child.stdout.on('data', (text) => (server.output += text));
    server.child.stderr.on('data', (text) => (server.output += text));
    server.child.on('error', (error) => (server.ended = error.message));
    server.child.on('exit', (code, signal) => (server.ended = signal ?? `exit code ${code}`));
    process.on('exit', () => server.ended === null && server.child.kill('SIGKILL'));
    return server;
  }

  get port() { return Number(this.base.split(':')[1]); }
  get url() { return `ws://${this.base}/ws`; }

  async healthy() {
    try {
      return (await fetch(`http://${this.base}/healthz`, { signal: AbortSignal.timeout(5000) })).ok;
    } catch {
      return false;
    }
  }

  async ready() {
    await until(async () => this.ended !== null || (await this.healthy()), 'the server did not answer');
    if (this.ended !== null) throw new Error(`the server ended with ${this.ended}`);
  }

  async end() {
    this.child.kill('SIGTERM');
    await until(() => this.ended !== null, 'the server did not end after SIGTERM', () => '', 10000);
  }
}
