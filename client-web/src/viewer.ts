// One viewer's session: what is known of the server and what was asked of it. The panels read `state` and hear of
// changes by topic. The rules between the two stand in reconnect.ts and frames.ts.

import { CameraController } from './camera/camera_controller.js';
import { framing, type Camera } from './camera/camera.js';
import type { Vec3 } from './camera/vector.js';
import { Display } from './picture/display.js';
import { Frames } from './frames.js';
import { Measuring } from './measuring.js';
import { pictureBox, placeInPicture } from './picture/picture_box.js';
import { parseFrame, ProtocolError, type Frame } from './wire/frame.js';
import { parseMessage, PROTOCOL, type Hello, type PathResult } from './wire/protocol.js';
import type { SceneMessage, SceneReady, ServerMessage, SettingValue, SettingValues } from './wire/protocol.js';
import { Restoring } from './reconnect.js';
import { onPixelRatio } from './picture/pixel_ratio.js';
import { pictureSize, type ResolutionMode } from './picture/resolution.js';
import { SettingsModel } from './panels/settings/settings_model.js';
import { PickModel } from './panels/pick/pick_model.js';
import { UndoStack } from './panels/settings/undo.js';
import { ShownMap } from './panels/shown_map.js';
import type { ErrorMap } from './wire/errors_message.js';
import type { Partition } from './wire/partition_message.js';
import { initialState, type Message, type Topic, type ViewerState } from './viewer_state.js';
import type { PictureFormat, ViewerMessage } from './wire/viewer_message.js';
import { StreamMeter } from './picture/stream_meter.js';
import { Seat } from './seat.js';
import { videoFaults, VideoSupport } from './picture/video_support.js';
import { viewOf, type Watching } from './watching.js';
import { Connection, socketUrl, type ConnectionState } from './wire/socket.js';
import { keepToken, takeToken, tokenOf } from './wire/token.js';

const RESIZE_DELAY = 150; // ms

export class Viewer {
  readonly state: ViewerState;
  readonly settings = new SettingsModel();
  readonly controller: CameraController;
  readonly partition = new ShownMap<Partition>(
    () => this.settings.value('showPartition') === true,
    () => this.emit('partition'),
  );
  readonly errors = new ShownMap<ErrorMap>(
    () => this.settings.value('showError') === true,
    () => this.emit('errors'),
  );
  readonly measuring = this.makeMeasuring();
  readonly pick = new PickModel(
    (id, x, y) => this.connection_.send({ type: 'pick', id, x, y }),
    () => this.emit('pick'),
  );
  readonly stream = new StreamMeter();
  readonly undo = new UndoStack();
  readonly seat: Seat;

  /** Set by the page. */
  onMessage: (message: Message) => void = () => undefined;
  onPicture: (frame: Frame) => void = () => undefined;

  private readonly listeners_ = new Map<Topic, (() => void)[]>();
  private readonly connection_: Connection;
  private readonly display_: Display;
  private readonly frames_: Frames;
  private readonly restoring_ = new Restoring();
  private readonly video_ = new VideoSupport(
    { changed: () => this.tellClient(), notice: (text) => this.onMessage({ kind: 'notice', text }) },
    videoFaults(window.VideoDecoder, window.isSecureContext),
  );
  private restTimer_ = 0;
  private resizeTimer_ = 0;
  private placed_ = false; // the camera is where the coming scene is to be seen from
  private pendingSettings_: Record<string, SettingValue> | null = null;

  constructor(
    private readonly canvas_: HTMLCanvasElement,
    resolutionMode: ResolutionMode,
  ) {
    this.state = initialState(resolutionMode);
    this.frames_ = new Frames(this.state, this.stream, {
      show: (frame) => this.display_.push(frame),
      skipped: () => this.display_.skipped(),
      acknowledge: (frameId, presentedMs, shownMs, undecodable) =>
        this.connection_.send({ type: 'ack', frameId, presentedMs, shownMs, undecodable }),
      undecodable: ({ frameId, codec }) =>
        this.onMessage({ kind: 'error', text: `Frame ${frameId} could not be decoded (${codec}).` }),
    });
    this.display_ = new Display(canvas_, {
      drawn: (frame) => [this.partition, this.errors].forEach((shown) => shown.drawn(frame)),
      presented: (presentation) => {
        this.frames_.presented(presentation);
        this.emit('frame');
      },
      dropped: (frame, reason) => this.frames_.dropped(frame, reason, performance.now()),
      partTaken: (frame) => this.frames_.partTaken(frame, performance.now()),
      videoFailed: (codec, reason) => this.video_.failed(codec, reason),
    });
    const hooks = {
      state: (state: ConnectionState) => this.connectionChanged(state),
      text: (text: string) => this.received(() => this.control(parseMessage(text))),
      binary: (buffer: ArrayBuffer) => this.received(() => this.binary(buffer)),
    };
    this.connection_ = new Connection(socketUrl(location.href), hooks, takeToken());
    this.seat = this.makeSeat();
    this.controller = new CameraController({
      schedule: () => requestAnimationFrame((time) => this.controller.step(time)),
      restAfter: (ms) => this.restAfter(ms),
      send: (camera, moving, eventTime) => this.sendCamera(camera, moving, eventTime),
      changed: () => this.emit('camera'),
    });
    window.addEventListener('resize', () => this.resized());
    window.addEventListener('hashchange', () => {
      if (tokenOf(location.href) !== null) this.connection_.setToken(takeToken()!);
    });
    onPixelRatio(() => this.resized());
    document.addEventListener('visibilitychange', () => this.tellClient());
    this.measure();
  }

  get watching(): Watching {
    return this.seat.watching;
  }

  on(topics: readonly Topic[], listener: () => void): void {
    for (const topic of topics) this.listeners_.set(topic, [...(this.listeners_.get(topic) ?? []), listener]);
  }

  connect(): void {
    this.connection_.open();
  }

  /** The viewer's answer to a server that asks for a token. */
  giveToken(token: string): void {
    keepToken(token);
    this.connection_.setToken(token);
  }

  /** A view, as an address states it: of the scene that is shown or another one. `camera` null: the scene's own. */
  lookAt(scene: string, camera: Camera | null): void {
    if (this.watching.active) return;
    if (this.state.readyName === scene) {
      this.restoring_.cancel();
      const place = camera ?? this.state.ready?.camera;
      if (place !== undefined) this.controller.jump(place);
      return;
    }
    if (camera !== null) {
      this.controller.place(camera);
      this.restoring_.begin(scene);
    } else if (this.state.hello === null) this.restoring_.begin(scene, false);
    this.connection_.send({ type: 'scene', name: scene });
  }

  /** The viewer asks for a viewpoint; from there dragging turns about `pivot`, where it is given. */
  jumpTo(camera: Camera, pivot: Vec3 | null = null): void {
    this.emit('jump');
    this.controller.jump(camera, pivot);
  }

  openScene(name: string, camera: Camera | null = null): void {
    if (this.seat.drivenByOthers()) return;
    this.emit('jump');
    if (camera !== null) return this.lookAt(name, camera);
    this.restoring_.cancel();
    this.connection_.send({ type: 'scene', name });
  }

  /** Shown at once; sent with the next animation frame, together with what else changes until then. */
  setSettings(values: SettingValues): void {
    if (!this.watching.maySet(Object.keys(values)) && this.seat.drivenByOthers()) return;
    this.undo.record(this.settings.valuesOf(Object.keys(values)), performance.now());
    this.changeSettings(values);
  }

  /** Takes the last change of settings back. */
  undoSettings(): void {
    const values = this.watching.active ? null : this.undo.pop();
    if (values !== null) this.changeSettings(values);
  }

  private changeSettings(values: SettingValues): void {
    if (this.pendingSettings_ === null) {
      this.pendingSettings_ = {};
      requestAnimationFrame(() => this.flushSettings());
    }
    Object.assign(this.pendingSettings_, values);
    this.settings.change(values, this.state.lastInputId + 1);
    this.partition.settingsChanged();
    this.emit('settings');
  }

  setResolutionMode(mode: ResolutionMode): void {
    this.state.resolutionMode = mode;
    this.sendResolution();
  }

  togglePath(): void {
    if (this.seat.drivenByOthers()) return;
    if (!this.state.pathPlaying && this.state.ready?.paths.length === 0) {
      this.onMessage({ kind: 'notice', text: 'This scene has no camera path to play. Choose another scene.' });
      return;
    }
    this.connection_.send({ type: 'path', playing: !this.state.pathPlaying });
  }

  savePicture(format: PictureFormat): void {
    if (!this.connection_.isOpen || this.state.ready === null) {
      this.onMessage({ kind: 'error', text: 'There is no picture to save yet. Wait until the scene is shown.' });
      return;
    }
    this.state.picturesAwaited += 1;
    this.connection_.send({ type: 'picture', format });
    this.emit('frame');
  }

  /** Asks what is at this place of the window, CSS pixels. */
  pickAt(x: number, y: number): void {
    const frame = this.state.lastFrame;
    if (frame === null || this.seat.drivenByOthers()) return;
    const window = this.canvas_.getBoundingClientRect();
    const place = placeInPicture(pictureBox(frame.width, frame.height, window.width, window.height), x, y);
    if (place !== null) this.pick.ask(place.x, place.y);
  }

  /** All of the scene, in the direction that is looked in. */
  frameAll(): void {
    const { ready, resolution } = this.state;
    if (this.seat.drivenByOthers() || ready === null) return;
    this.jumpTo(framing(this.controller.camera, ready.bounds, resolution.width / resolution.height));
  }

  resetView(): void {
    if (this.seat.drivenByOthers()) return;
    if (this.state.ready !== null) this.jumpTo(this.state.ready.camera);
  }

  private emit(topic: Topic): void {
    for (const listener of this.listeners_.get(topic) ?? []) listener();
  }

  private nextInputId(): number {
    this.state.lastInputId += 1;
    return this.state.lastInputId;
  }

  private received(handle: () => void): void {
    try {
      handle();
    } catch (error) {
      if (!(error instanceof ProtocolError)) throw error;
      const text = `The server sent something this page cannot read (${error.message}).`;
      if (!this.measuring.refused(text, error.message.split('.')[0]!)) this.onMessage({ kind: 'error', text });
    }
  }

  private connectionChanged(state: ConnectionState): void {
    this.state.connection = state;
    if (state.name === 'open') {
      this.stream.roundTrips.clear();
    } else if (state.name === 'waiting' || state.name === 'stopped') {
      this.display_.reset();
      this.frames_.reset();
      this.partition.forget();
      this.measuring.disconnected();
      this.stream.motionToPhoton.reset();
      this.stream.trace.reset();
      this.state.picturesAwaited = 0;
      this.state.pathPlaying = false;
      this.state.scene = null; // until the server says what it shows
      this.controller.enabled = true;
      for (const topic of ['scene', 'path', 'frame'] as const) this.emit(topic);
    }
    this.emit('connection');
  }

  private control(message: ServerMessage | null): void {
    switch (message?.type) {
      case 'hello':
        return this.hello(message);
      case 'scene':
        return this.seat.holdBack(message) ? undefined : this.scene(message);
      case 'settings':
        this.settings.echo(message.values, message.inputId);
        this.video_.asked(message.values['codec']);
        this.partition.settingsChanged();
        return this.emit('settings');
      case 'effectCosts':
      case 'accuracy':
        return this.measuring.answered(message, this.state.readyName);
      case 'picked':
        return this.pick.answered(message);
      case 'errors':
        return this.errors.received(message);
      case 'partition':
        return this.partition.received(message);
      case 'watching':
        return this.seat.answered(message);
      case 'driveAsked':
        return this.seat.asked(message.viewer);
      case 'resolution':
        this.state.given = { width: message.given[0], height: message.given[1] };
        return this.emit('resolution');
      case 'stats':
        this.state.stats = message;
        return this.emit('stats');
      case 'path':
        return this.path(message.playing, message.result);
      case 'notice':
        return this.onMessage({ kind: 'notice', text: message.text });
      case 'error':
        return this.error(message.message, message.about, message.inputId);
      case 'pong':
        this.connection_.roundTripMs = performance.now() - message.time;
        return this.stream.roundTrips.push(this.connection_.roundTripMs);
      case undefined:
        return; // a message of a kind that this page does not know
    }
  }

  private hello(hello: Hello): void {
    if (hello.protocol !== PROTOCOL) {
      this.connection_.stop(`The server speaks ${hello.protocol}, this page ${PROTOCOL}. Reload the page.`);
      return;
    }
    this.connection_.confirm();
    const before = this.state.hello;
    this.state.hello = hello;
    this.state.ownScene = '';
    this.settings.setSchema(hello.schema);
    this.video_.served(hello.videos);
    this.tellClient();
    if (before !== null && before.server !== hello.server) {
      this.onMessage({
        kind: 'notice',
        text: `The server is now version ${hello.server}. Reload the page to match it.`,
      });
    }
    this.emit('hello');
    this.emit('settings');
    this.seat.greeted(hello);
  }

  /** A page that nobody sees is sent nothing. */
  private tellClient(): void {
    this.connection_.send({ type: 'client', visible: !document.hidden, exact: true, ...this.video_.shown });
  }

  private makeMeasuring(): Measuring {
    return new Measuring({
      send: (message) => this.connection_.send(message),
      changed: (topic) => this.emit(topic),
      may: () => !this.seat.drivenByOthers() && this.connection_.isOpen && this.state.ready !== null,
      now: () => ({ camera: this.controller.camera, values: this.settings.values(), size: this.state.resolution }),
    });
  }

  private makeSeat(): Seat {
    const hooks = {
      send: (message: ViewerMessage) => this.connection_.send(message),
      nextInputId: () => this.nextInputId(),
      notice: (text: string) => this.onMessage({ kind: 'notice', text }),
      changed: () => {
        this.controller.enabled = !this.watching.active && !this.state.pathPlaying;
        if (this.watching.active) this.measuring.accuracy.handedOver();
        this.emit('watching');
      },
      drive: (restore: boolean) => this.drive(restore),
      goOn: (camera: Camera | null, now: boolean) => this.goOn(camera, now),
      scene: (message: SceneMessage) => this.scene(message),
    };
    return new Seat(hooks, viewOf(location.href));
  }

  /** Tells the server what this page wants of its own view. `restore`: with the scene and the camera from before. */
  private drive(restore: boolean): void {
    if (restore && this.state.readyName !== '') this.restoring_.begin(this.state.readyName);
    this.sendResolution();
    const values = this.settings.restorable();
    if (Object.keys(values).length > 0) this.changeSettings(values);
  }

  /** Drives a view from where others left it. `now`: its scene is shown already, else it is to come. */
  private goOn(camera: Camera | null, now: boolean): void {
    this.placed_ = camera !== null && !now;
    if (this.placed_) this.controller.place(camera!);
    else if (camera !== null) this.controller.jump(camera);
    this.sendResolution();
  }

  private scene(message: SceneMessage): void {
    if (this.state.ownScene === '') this.state.ownScene = message.name;
    const { show, ask } = this.restoring_.step(message, this.state.hello?.scenes.map((entry) => entry.name) ?? []);
    if (ask !== null) this.connection_.send({ type: 'scene', name: ask });
    if (!show) return;
    this.state.scene = message;
    if (message.ready !== null) this.sceneReady(message.name, message.ready);
    if (message.state === 'failed') {
      this.onMessage({ kind: 'error', text: `The scene ${message.name} could not be opened: ${message.what}` });
      this.giveUpRestoring();
    }
    this.emit('scene');
  }

  /** The scene from before cannot be had again: the server's own takes its place. */
  private giveUpRestoring(): void {
    const own = this.restoring_.giveUp();
    if (own !== null) this.scene(own);
  }

  private sceneReady(name: string, ready: SceneReady): void {
    const restored = this.restoring_.finish(name);
    this.partition.forget();
    this.state.ready = ready;
    if (this.state.readyName !== name) {
      this.measuring.sceneChanged();
      this.pick.forget();
    }
    this.state.readyName = name;
    this.state.pathResult = null;
    this.controller.setScene(ready.bounds, ready.radius);
    if (restored || this.placed_) this.controller.resend();
    else this.controller.jump(ready.camera);
    this.placed_ = false;
  }

  private path(playing: boolean, result: PathResult | null): void {
    const stopped = this.state.pathPlaying && !playing;
    this.state.pathPlaying = playing;
    if (playing) this.state.pathResult = null;
    if (result !== null) this.state.pathResult = result;
    this.controller.enabled = !playing && !this.watching.active;
    if (stopped) this.controller.resend();
    this.emit('path');
  }

  private error(message: string, about: string, inputId: number | null): void {
    if (about === 'picture') this.state.picturesAwaited = Math.max(0, this.state.picturesAwaited - 1);
    const names = about === 'settings' ? this.settings.refused(message, inputId) : [];
    if (about === 'scene') this.giveUpRestoring();
    if (about === 'watch' && this.seat.refused()) return;
    if (this.measuring.refused(message, about)) return;
    if (about === 'pick') this.pick.forget();
    if (names.length === 0) this.onMessage({ kind: 'error', text: message });
    this.emit('settings');
    this.emit('frame');
  }

  private binary(buffer: ArrayBuffer): void {
    const frame = parseFrame(buffer, this.state.hello?.devices ?? []);
    this.stream.receivedRate.push(performance.now(), buffer.byteLength);
    if (frame.kind !== 'picture') {
      // While the scene or the view from before a reconnect is on its way, frames show the server's own: not what was looked at.
      this.frames_.arrived(frame, this.restoring_.active || this.watching.awaits, performance.now());
      return;
    }
    this.state.picturesAwaited = Math.max(0, this.state.picturesAwaited - 1);
    this.onPicture(frame);
    this.emit('frame');
  }

  private sendCamera(camera: Camera, moving: boolean, eventTime: number | null): void {
    if (this.watching.active) return;
    const inputId = this.nextInputId();
    if (this.connection_.isOpen) this.stream.sent(inputId, eventTime, performance.now());
    this.connection_.send({ type: 'camera', inputId, moving, ...camera });
  }

  private restAfter(ms: number | null): void {
    window.clearTimeout(this.restTimer_);
    if (ms !== null) this.restTimer_ = window.setTimeout(() => this.controller.rest(performance.now()), ms);
  }

  private flushSettings(): void {
    const values = this.pendingSettings_;
    this.pendingSettings_ = null;
    if (values === null) return;
    const inputId = this.nextInputId();
    this.settings.change(values, inputId);
    this.connection_.send({ type: 'settings', inputId, values });
  }

  private resized(): void {
    window.clearTimeout(this.resizeTimer_);
    this.resizeTimer_ = window.setTimeout(() => this.sendResolution(), RESIZE_DELAY);
  }

  private measure(): void {
    const box = this.canvas_.getBoundingClientRect();
    this.controller.viewHeight = box.height;
    this.state.resolution = pictureSize(box.width, box.height, window.devicePixelRatio, this.state.resolutionMode);
  }

  private sendResolution(): void {
    this.measure();
    this.state.given = null;
    if (!this.watching.active)
      this.connection_.send({ type: 'resolution', inputId: this.nextInputId(), ...this.state.resolution });
    this.emit('resolution');
  }
}
