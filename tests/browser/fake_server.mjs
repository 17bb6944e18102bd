// A stand-in for the server, speaking docs/reference/protocol.md, to work on the page without one and to test what a real server
// seldom does. Started like the real one: fake_server.mjs serve [SCENE] --listen 127.0.0.1:PORT
// HELIOGRAPH_FAKE_OMIT leaves settings out of the table (names with commas); HELIOGRAPH_FAKE_TOKEN is a token to ask for;
// HELIOGRAPH_FAKE_SET are settings to start with, as JSON.

import { readFileSync } from 'node:fs';
import { createServer } from 'node:http';
import { createRequire } from 'node:module';
import { dirname, extname, join } from 'node:path';
import { fileURLToPath } from 'node:url';
import { deviceKinds, effectCosts, effects, PARTS, partition, SCHEDULER, schema } from './fake_data.mjs';
import { accuracy } from './fake_accuracy.mjs';
import { paint } from './fake_picture.mjs';

const here = dirname(fileURLToPath(import.meta.url));
const client = join(here, '../../client-web');
const { WebSocketServer } = createRequire(join(client, 'package.json'))('ws');

const listen = process.argv[process.argv.indexOf('--listen') + 1] ?? '127.0.0.1:8080';
const [host, port] = listen.split(':');
const firstScene = process.argv[2] === 'serve' && !process.argv[3]?.startsWith('--') ? process.argv[3] : 'cornell';

const omitted = (process.env.HELIOGRAPH_FAKE_OMIT ?? '').split(',');
const SCHEMA = schema(omitted);

/** What the tests change by /control?name=value, and what viewers said, which /received answers and forgets. */
const control = { partition: 'on', costs: 'ready', accuracy: 'ready', given: '', refuse: '', why: '', idle: '' };
let received = [];

const SCENES = [
  { name: 'cornell', description: 'A box with two coloured walls: the classic test of light between surfaces.' },
  { name: 'courtyard', description: 'Arches and colonnades on two floors around a sunlit court.' },
  { name: 'broken', description: 'Fails to open, for tests.' },
];
const START = {
  position: [0.6, 2.2, 7.5],
  forward: [-0.0755, -0.151, -0.9856],
  up: [-0.0115, 0.9885, -0.1506],
  fieldOfView: 50,
};

class FakeViewer {
  settings = {
    ...Object.fromEntries(SCHEMA.map((row) => [row.name, row.default])),
    ...JSON.parse(process.env.HELIOGRAPH_FAKE_SET ?? '{}'),
  };
  camera = START;
  size = null;
  inputId = 0;
  samples = 0;
  frameId = 0;
  generation = 0;
  unacked = new Set();
  scene = null;
  moving = false;
  path = null;
  framesSent = 0;

  constructor(socket) {
    this.socket = socket;
    socket.on('message', (data, binary) => (binary ? socket.close(1003) : this.receive(JSON.parse(data.toString()))));
    this.say({
      type: 'hello',
      protocol: 'heliograph.v1',
      server: '0.1.0-fake',
      viewer: 1,
      view: '0123456789abcdef0123456789abcdef',
      schema: SCHEMA,
      devices: deviceKinds(),
      scenes: SCENES,
      videos: ['vp9'],
      maxUnacked: 2,
    });
    this.say({ type: 'settings', values: this.settings });
    this.open(firstScene);
    this.timers = [setInterval(() => this.frame(), 30), setInterval(() => this.stats(), 500)];
    socket.on('close', () => [...this.timers, this.sweep].forEach(clearInterval));
  }

  say(message) {
    this.socket.send(JSON.stringify(message));
  }

  refuse(message, about, inputId) {
    this.say({ type: 'error', message, about, inputId });
  }

  changed(inputId) {
    this.inputId = inputId ?? this.inputId;
    this.samples = 0;
    this.generation += 1;
  }

  open(name) {
    if (!SCENES.some((scene) => scene.name === name.split('#')[0]))
      return this.refuse(`scene.name: "${name}", allowed: ${SCENES.map((s) => s.name).join(', ')}`, 'scene');
    const steps = ['reading', 'textures', 'building the acceleration structure'];
    // One after the other: timers that are all late do not run in the order of their times.
    const step = (i) => {
      if (i === steps.length) return this.opened(name);
      this.say({ type: 'scene', name, state: 'loading', what: steps[i], share: (i + 1) / 4 });
      setTimeout(() => step(i + 1), 130);
    };
    setTimeout(() => step(0), 0);
  }

  opened(name) {
    if (name === 'broken')
      return this.say({ type: 'scene', name, state: 'failed', what: 'meshes[0]: 3 indices, found 2' });
    this.scene = name;
    this.camera = START;
    this.changed();
    this.say({
      type: 'scene',
      name,
      state: 'ready',
      camera: START,
      cameras: [
        { name: 'start', ...START },
        {
          name: 'from above',
          ...START,
          position: [0, 6, 9],
          forward: [0, -0.5547, -0.83205],
          up: [0, 0.83205, -0.5547],
        },
      ],
      paths: ['tour'],
      variants: name.startsWith('cornell') ? ['beach', 'street'] : [],
      variant: name.includes('#') ? ['beach', 'street'].indexOf(name.split('#')[1]) : null,
      bounds: { low: [-3, 0, -3], high: [3, 3, 3] },
      radius: 4.5,
      triangles: 66454,
      instances: 12,
      lights: 1,
      effects: effects(control.idle),
      warnings:
        name === 'courtyard'
          ? [
              'No light in the file: a headlight was added.',
              'Extension KHR_materials_sheen is not known and was left out.',
            ]
          : [],
    });
  }

  receive(message) {
    if (message.type !== 'ack' && message.type !== 'ping') received.push(message);
    switch (message.type) {
      case 'ack':
        this.unacked.delete(message.frameId);
        return;
      case 'ping':
        return this.say({ type: 'pong', time: message.time });
      case 'scene':
        return this.open(message.name);
      case 'resolution':
        return this.resize(message);
      case 'camera':
        if (this.path === null) {
          this.camera = message;
          this.moving = message.moving;
          this.changed(message.inputId);
        }
        return;
      case 'settings':
        return this.set(message);
      case 'picture':
        return this.picture(message.format);
      case 'path':
        return this.play(message.playing);
      case 'effectCosts':
        return this.measure();
      case 'accuracy':
        return this.measureView(message.seconds);
      case 'watch': // a new connection knows no view but its own
        return this.say({ type: 'error', message: 'watch.view: no such view', about: 'watch', inputId: message.inputId });
      case 'client': // what the viewer's computer is, and whether the page is seen: nothing to answer
        return;
      case 'pick':
        return this.pick(message);
      default:
        this.refuse(`type: "${message.type}", allowed: camera, settings, ...`, message.type);
    }
  }

  set({ values, inputId }) {
    for (const [name, value] of Object.entries(values)) {
      const row = SCHEMA.find((entry) => entry.name === name);
      if (row === undefined) return this.refuse(`${name}: no such setting`, 'settings', inputId);
      const number = row.type === 'int' || row.type === 'float';
      if (number && !(value >= row.low && value <= row.high))
        return this.refuse(`${name}: ${value}, allowed: ${row.low} to ${row.high}`, 'settings', inputId);
    }
    Object.assign(this.settings, values);
    this.changed(inputId);
    this.say({ type: 'settings', values: this.settings, inputId });
  }

  resize({ width, height, inputId }) {
    const given = control.given === '' ? [width, height] : control.given.split('x').map(Number);
    this.size = { width: given[0], height: given[1] };
    if (control.given !== '')
      this.say({ type: 'resolution', wanted: [width, height], given, text: 'short', inputId });
    this.changed(inputId);
  }

  measure() {
    if (control.costs === 'error') return this.refuse('effectCosts: the device is busy, try again', 'effectCosts');
    const scene = this.scene;
    this.say({ type: 'effectCosts', state: 'measuring', share: 0 });
    setTimeout(() => this.say({ type: 'effectCosts', state: 'measuring', share: 0.5 }), 300);
    const finish = () => {
      if (control.costs === 'hold') return void setTimeout(finish, 50);
      this.say(effectCosts(scene));
    };
    setTimeout(finish, 900);
  }

  /** Ends when `control.accuracy` is no longer "hold": by what it says, or by the viewer's wish. */
  measureView(seconds) {
    clearInterval(this.sweep);
    const say = (state, more = {}) => this.say({ type: 'accuracy', state, ...more });
    if (control.accuracy === 'refuse') return this.refuse('accuracy: only who drives a view may have it measured', 'accuracy');
    if (seconds === 0) return say('given-up');
    const begin = { scene: this.scene, camera: this.camera };
    let step = 0;
    const next = () => {
      if (this.scene !== begin.scene || (step === 3 && control.accuracy !== 'hold')) clearInterval(this.sweep);
      if (this.scene !== begin.scene) return say('given-up');
      if (step < 3) return say('measuring', { share: 0.2 * step, what: `aoSamples=${(step++ + 1) ** 2}, about ${seconds - step} s left` });
      if (control.accuracy === 'ready') this.say(accuracy(begin.scene, begin.camera));
      if (control.accuracy === 'broken') say('ready', { size: [0, 0] });
      if (control.accuracy === 'failed') say('failed', { what: 'the device was lost' });
    };
    next();
    this.sweep = setInterval(next, 100);
  }

  /** A chair in front of a wall; the sky above. */
  pick({ x, y, id }) {
    if (y < 0.1) return this.say({ type: 'picked', id, found: false });
    const depth = x < 0.6 ? 4 : 7;
    const tangent = Math.tan(((this.camera?.fieldOfView ?? START.fieldOfView) * Math.PI) / 360);
    const { position, forward, up } = this.camera ?? START;
    const right = [forward[1] * up[2] - forward[2] * up[1], forward[2] * up[0] - forward[0] * up[2], forward[0] * up[1] - forward[1] * up[0]];
    const [across, high] = [(2 * x - 1) * tangent * (this.size.width / this.size.height), (1 - 2 * y) * tangent];
    const along = [0, 1, 2].map((i) => forward[i] + across * right[i] + high * up[i]);
    this.say({
      type: 'picked',
      id,
      found: true,
      object: x < 0.6 ? 'chair' : '',
      material: x < 0.6 ? 'oak' : 'plaster',
      distance: depth * Math.hypot(...along),
      depth,
      position: along.map((value, i) => position[i] + depth * value),
      normal: [0, 0, 1],
    });
  }

  play(playing) {
    if (playing) this.path = { since: Date.now(), frames: 0 };
    else if (this.path !== null) this.pathEnded();
    if (playing) this.say({ type: 'path', playing: true });
  }

  pathEnded() {
    const { frames } = this.path;
    this.path = null;
    this.say({
      type: 'path',
      playing: false,
      result: { frames, msMean: 31.2, msMedian: 30.1, msP95: 44.8, fpsMean: 32, fpsMin: 19.4 },
    });
  }

  picture(format) {
    const { width, height } = this.size;
    const payload =
      format === 'png' ? paint(this.scene, this.camera, width, height, this.settings.exposure) : Buffer.from('v/1\x01');
    this.socket.send(this.header(2, { png: 1, exr: 2, jpg: 0 }[format], width, height, payload));
  }

  error() {
    return 0.12 / Math.sqrt(Math.max(1, this.samples));
  }

  /** All samples are there, or the picture's error is as small as asked for. */
  finished() {
    const { samples, errorTarget } = this.settings;
    return this.samples >= samples || (this.samples >= 4 && 100 * this.error() <= errorTarget);
  }

  frame() {
    if (this.size === null || this.scene === null || this.unacked.size >= 2 || this.finished())
      return;
    if (this.path !== null) {
      const angle = (Date.now() - this.path.since) / 1500;
      this.camera = {
        ...START,
        position: [7 * Math.sin(angle), 2, 7 * Math.cos(angle)],
        forward: [-Math.sin(angle), -0.1, -Math.cos(angle)],
        up: [0, 1, 0],
      };
      this.path.frames += 1;
      this.samples = 0;
      if (angle > 4) this.pathEnded();
    }
    const scale = this.moving || this.samples === 0 ? 4 : 2;
    const width = Math.max(16, Math.round(this.size.width / scale));
    const height = Math.max(16, Math.round(this.size.height / scale));
    this.samples = this.moving ? 1 : Math.min(this.settings.samples, this.samples === 0 ? 1 : this.samples * 2);
    const payload = paint(this.scene, this.camera, width, height, this.settings.exposure);
    this.frameId += 1;
    this.unacked.add(this.frameId);
    // The courtyard is rendered by more workers than a timeline has rows.
    const [workers, batches] = this.scene === 'courtyard' ? [48, 200] : [6, 5];
    if (this.settings.showPartition && control.partition === 'on')
      this.say(partition(this.frameId, width, height, workers, batches));
    if (this.settings.showError && this.samples > 1) this.errors(width, height);
    this.socket.send(this.header(1, 1, width, height, payload));
  }

  /** More from left to right, up to three times the picture's. */
  errors(width, height) {
    const [columns, rows] = [Math.ceil(width / 32), Math.ceil(height / 32)];
    const cells = Array.from({ length: columns * rows }, (_, i) =>
      i === 0 ? null : Math.round((3e4 * this.error() * (i % columns)) / columns),
    );
    this.say({ type: 'errors', frameId: this.frameId, width, height, cellWidth: 32, cellHeight: 32, cells });
  }

  header(kind, codec, width, height, payload) {
    const header = Buffer.alloc(64);
    header.write('HG', 'latin1');
    header.set([kind, codec], 2);
    header.writeUInt16LE(64, 4);
    const ended = this.finished() ? (this.samples < this.settings.samples ? 18 : 2) : 0;
    header.set([(this.moving ? 1 : 0) | ended, this.settings.jpegQuality], 6);
    [this.frameId, this.inputId, this.generation].forEach((value, i) => header.writeUInt32LE(value, 8 + 4 * i));
    [width, height, this.size.width, this.size.height].forEach((value, i) => header.writeUInt16LE(value, 20 + 2 * i));
    header.writeUInt32LE(this.samples, 28);
    header.writeFloatLE(this.error(), 32);
    [21400, 1900, 3100, 800, 400].forEach((value, i) => header.writeUInt32LE(value, 36 + 4 * i));
    header.writeUInt32LE(payload.length, 56);
    header.writeUInt32LE(1, 60);
    return Buffer.concat([header, payload]);
  }

  /** Nine rays of occlusion instead of 25, for any budget. */
  autopilot() {
    const budgetMs = this.settings.timeBudget;
    if (!(budgetMs > 0)) return null;
    const steps = [{ setting: 'aoSamples', before: '25', after: '9', msWithout: 2 * budgetMs }];
    return { budgetMs, ms: 0.8 * budgetMs, scale: 1, steps };
  }

  stats() {
    this.say({
      type: 'stats',
      device: this.settings.device === 'hybrid' ? 'hybrid' : 'embree',
      framesPerSecond: 33.2,
      samples: this.samples,
      targetSamples: this.settings.samples,
      relativeError: 0.05,
      forecast: {
        plateau: false,
        steps: [
          { error: 0.02, samples: this.settings.samples / 2, seconds: 4.2 },
          { error: 0.01, samples: this.settings.samples * 4, seconds: 60 },
        ],
      },
      autopilot: this.autopilot(),
      ...(this.settings.autoExposure === 'on' ? { autoExposure: 1.26 } : {}),
      rays: {
        primary: 1296000,
        shadow: 2310400,
        ambient_occlusion: 0,
        reflection: 402100,
        refraction: 12300,
        total: 4020800,
      },
      mraysPerSecond: 38.7,
      ms: { render: 21.4, develop: 1.9, encode: 3.1, queue: 0.8, send: 0.4 },
      overheadShare: 0.12,
      tiles: { embree: 1305 },
      ...(this.settings.device === 'hybrid'
        ? { tiles: { embree: 810, 'vulkan:0': 1280 }, parts: PARTS, scheduler: SCHEDULER }
        : {}),
      viewers: 1,
      watchers: 0,
      residentBytes: 312_000_000,
      nonfiniteSamples: 0,
    });
  }
}

const TYPES = { '.html': 'text/html', '.js': 'text/javascript', '.css': 'text/css', '.svg': 'image/svg+xml' };
const POLICY = "default-src 'self'; style-src 'self'; img-src 'self' blob: data:; connect-src 'self' ws: wss:";

const http = createServer((request, response) => {
  const path = request.url === '/' ? '/index.html' : request.url.split('?')[0];
  if (path === '/healthz') return void response.end('ok\n');
  if (path === '/ws') return void response.writeHead(Number(control.refuse || 426)).end(control.why);
  if (path.startsWith('/thumbnails/')) return void response.end();
  if (path === '/control') {
    Object.assign(control, Object.fromEntries(new URLSearchParams(request.url.split('?')[1])));
    return void response.end('ok\n');
  }
  if (path === '/received') {
    response.end(JSON.stringify(received));
    received = [];
    return;
  }
  try {
    const body = readFileSync(join(client, 'dist', path.replaceAll('..', '')));
    response.writeHead(200, {
      'content-type': TYPES[extname(path)] ?? 'application/octet-stream',
      'content-security-policy': POLICY,
    });
    response.end(body);
  } catch {
    response.writeHead(404).end();
  }
});
const sockets = new WebSocketServer({
  noServer: true,
  handleProtocols: (offered) => (offered.has('heliograph.v1') ? 'heliograph.v1' : false),
});
http.on('upgrade', (request, socket, head) => {
  if (control.refuse !== '') return socket.end(`HTTP/1.1 ${control.refuse} Refused\r\ncontent-length: 0\r\n\r\n`);
  sockets.handleUpgrade(request, socket, head, (opened) => admit(opened));
});

/** Lets in who says the token first, where there is one. */
function admit(socket) {
  const token = process.env.HELIOGRAPH_FAKE_TOKEN;
  if (token === undefined) return void new FakeViewer(socket);
  socket.once('message', (data) => {
    const message = JSON.parse(data.toString());
    if (message.type === 'token' && message.token === token) new FakeViewer(socket);
    else socket.close(4001);
  });
}
http.listen(Number(port), host, () => console.log(`fake server on http://${host}:${port}`));
