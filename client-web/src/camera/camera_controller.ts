// Turns input into cameras: integrates held keys over time, gathers everything between two animation frames into one
// absolute camera, and says when the motion has ended. Knows no DOM; time and animation frames come from outside.

import {
  DEFAULT_CAMERA,
  lengthPerPixel,
  lookOnScreen,
  move,
  orbit,
  pivotDistance,
  roll,
  withFieldOfView,
  type Bounds,
  type Camera,
} from './camera.js';
import { clamp, length, subtract, type Vec3 } from './vector.js';

export type NavigationMode = 'fly' | 'orbit';

/** What a held key does; values of opposite pairs add up. */
export type HeldAction =
  | 'forward'
  | 'back'
  | 'left'
  | 'right'
  | 'rollLeft'
  | 'rollRight'
  | 'faster'
  | 'slower'
  | 'widen'
  | 'narrow'
  | 'lookLeft'
  | 'lookRight'
  | 'lookUp'
  | 'lookDown';

/** How far a stick or a trigger is pushed, -1 to 1 each. */
export interface Push {
  readonly right?: number;
  readonly up?: number;
  readonly forward?: number;
  readonly turnRight?: number;
  readonly turnUp?: number;
  readonly faster?: number; // ten times at 1, a tenth at -1
}

export interface ControllerHooks {
  /** One call of `step` at the next animation frame. */
  schedule(): void;
  /** One call of `rest` after `ms`, replacing an earlier one; null cancels. */
  restAfter(ms: number | null): void;
  /**
   * `eventTime`: when the oldest input in this camera happened, performance.now() milliseconds; null: it came by no motion of
   * the viewer.
   */
  send(camera: Camera, moving: boolean, eventTime: number | null): void;
  /** The camera or the mode changed, for the panels. */
  changed(): void;
}

/** Without a change for this long the camera counts as resting, ms. */
export const REST_DELAY = 120;
const LONGEST_STEP = 0.1; // s; a stalled page does not leap
const MOVE_SPEED = 0.2; // scene radii per second
const ROLL_SPEED = Math.PI / 3; // radians per second
const LOOK_SPEED = Math.PI / 3; // radians per second with the arrow keys
const STICK_GAIN = 2; // a stick that is pushed all the way turns so much faster than an arrow key
const FIELD_OF_VIEW_SPEED = 30; // degrees per second
const MOUSE_GAIN = 2; // mouse-look turns this much more than the picture under the pointer
const FINGER_GAIN = 2.5;
const PINCH_GAIN = 0.2; // scene radii for fingers that move e times as far apart
const ORBIT_PER_HEIGHT = Math.PI; // radians for a drag over the whole height
const WHEEL_NOTCH = 100; // wheel pixels of one notch
const ZOOM_PER_NOTCH = 1.15;

export class CameraController {
  private camera_: Camera = DEFAULT_CAMERA;
  private mode_: NavigationMode = 'fly';
  private enabled_ = true;
  private radius_ = 1;
  private bounds_: Bounds = { low: [-1, -1, -1], high: [1, 1, 1] };
  private distance_ = 1; // to the orbit's pivot, along forward
  private viewHeight_ = 1; // CSS pixels
  private readonly held_ = new Set<HeldAction>();
  private readonly pushed_ = new Map<string, Push>(); // by what pushes
  private dirty_ = false;
  private moving_ = false; // the server was last told `moving`
  private eventTime_ = 0;
  private scheduled_ = false;
  private lastStep_: number | null = null;

  constructor(private readonly hooks_: ControllerHooks) {}

  get camera(): Camera {
    return this.camera_;
  }

  get mode(): NavigationMode {
    return this.mode_;
  }

  /** Keys of flying are held. */
  get flying(): boolean {
    return this.held_.size > 0;
  }

  private get driven(): boolean {
    return this.held_.size > 0 || this.pushed_.size > 0;
  }

  /** Off while the server moves the camera along a path. */
  set enabled(on: boolean) {
    this.enabled_ = on;
    if (!on) this.releaseAll(0);
  }

  set viewHeight(pixels: number) {
    this.viewHeight_ = Math.max(1, pixels);
  }

  setScene(bounds: Bounds, radius: number): void {
    this.bounds_ = bounds;
    this.radius_ = radius;
    this.distance_ = pivotDistance(this.camera_, bounds, radius);
  }

  setMode(mode: NavigationMode): void {
    this.mode_ = mode;
    this.distance_ = pivotDistance(this.camera_, this.bounds_, this.radius_);
    this.hooks_.changed();
  }

  /** Jumps to a viewpoint; sent at once as a resting camera. With a `pivot`, straight ahead, dragging orbits about it. */
  jump(camera: Camera, pivot: Vec3 | null = null): void {
    this.camera_ = camera;
    this.distance_ = pivotDistance(camera, this.bounds_, this.radius_);
    if (pivot !== null) {
      this.mode_ = 'orbit';
      this.distance_ = Math.max(length(subtract(pivot, camera.position)), 1e-3 * this.radius_);
    }
    this.finish(null);
    this.hooks_.changed();
  }

  /** A viewpoint of a scene that is yet to come; not sent. */
  place(camera: Camera): void {
    this.camera_ = camera;
    this.hooks_.changed();
  }

  /** Sends the present camera again, as after a reconnect. */
  resend(): void {
    this.finish(null);
  }

  setFieldOfView(degrees: number, time: number): void {
    this.change(withFieldOfView(this.camera_, degrees), time);
  }

  /** A drag by CSS pixels. `grab`: the picture follows the finger; else the view turns towards the drag. */
  turn(dx: number, dy: number, grab: boolean, time: number): void {
    const height = this.viewHeight_;
    if (this.mode_ === 'orbit') {
      const angle = ORBIT_PER_HEIGHT / height;
      this.change(orbit(this.camera_, this.distance_, -dx * angle, dy * angle), time);
      return;
    }
    const perPixel = (this.camera_.fieldOfView * Math.PI) / 180 / height;
    const angle = perPixel * (grab ? -FINGER_GAIN : MOUSE_GAIN);
    this.change(lookOnScreen(this.camera_, dx * angle, -dy * angle), time);
  }

  /** Moves the picture with the pointer, in the plane through the pivot. */
  pan(dx: number, dy: number, time: number): void {
    const unit = lengthPerPixel(this.camera_, this.distance_, this.viewHeight_);
    this.change(move(this.camera_, -dx * unit, dy * unit, 0), time);
  }

  /** Comes nearer by `factor` > 1: towards the pivot in orbit mode, straight ahead in fly mode. */
  zoom(factor: number, time: number): void {
    if (this.mode_ === 'orbit') {
      const next = clamp(this.distance_ / factor, 1e-3 * this.radius_, 100 * this.radius_);
      const forward = this.distance_ - next;
      this.distance_ = next;
      this.change(move(this.camera_, 0, 0, forward), time);
      return;
    }
    this.change(move(this.camera_, 0, 0, Math.log(factor) * 0.5 * this.radius_), time);
  }

  /** Two fingers move `factor` times as far apart. */
  pinch(factor: number, time: number): void {
    if (this.mode_ === 'orbit') this.zoom(factor, time);
    else this.change(move(this.camera_, 0, 0, Math.log(factor) * PINCH_GAIN * this.radius_), time);
  }

  /** `pixels` of wheel travel, > 0 away from the scene. */
  wheel(pixels: number, time: number): void {
    this.zoom(Math.pow(ZOOM_PER_NOTCH, -pixels / WHEEL_NOTCH), time);
  }

  press(action: HeldAction, time: number): void {
    if (!this.enabled_ || this.held_.has(action)) return;
    this.held_.add(action);
    if (!this.dirty_) this.eventTime_ = time;
    this.schedule();
  }

  release(action: HeldAction, time: number): void {
    if (this.held_.delete(action)) this.end(time);
  }

  /** A stick named `source` stands so; null: it was let go. */
  push(source: string, push: Push | null, time: number): void {
    if (push === null) {
      if (this.pushed_.delete(source)) this.end(time);
      return;
    }
    if (!this.enabled_) return;
    this.pushed_.set(source, push);
    if (!this.dirty_ && !this.scheduled_) this.eventTime_ = time;
    this.schedule();
  }

  releaseAll(time: number): void {
    if (!this.driven) return;
    this.held_.clear();
    this.pushed_.clear();
    if (this.enabled_) this.end(time);
  }

  /** The pointer was let go: nothing moves any more unless a key is held. */
  end(time: number): void {
    if (!this.driven && (this.dirty_ || this.moving_)) this.finish(this.dirty_ ? this.eventTime_ : time);
  }

  /** The animation frame that `schedule` asked for. */
  step(time: number): void {
    this.scheduled_ = false;
    const seconds = this.lastStep_ === null ? 1 / 60 : Math.min(LONGEST_STEP, (time - this.lastStep_) / 1000);
    this.lastStep_ = time;
    this.applyHeld(Math.max(0, seconds), time);
    if (this.dirty_) {
      this.dirty_ = false;
      this.moving_ = true;
      this.hooks_.send(this.camera_, true, this.eventTime_);
      this.hooks_.restAfter(REST_DELAY);
    }
    if (this.driven) this.schedule();
    else this.lastStep_ = null;
  }

  /** The pause that `restAfter` asked for. */
  rest(time: number): void {
    if (this.moving_ && !this.dirty_) this.finish(time);
  }

  private applyHeld(seconds: number, time: number): void {
    const axis = (plus: HeldAction, minus: HeldAction): number =>
      Number(this.held_.has(plus)) - Number(this.held_.has(minus));
    const pushed = (along: keyof Push): number =>
      [...this.pushed_.values()].reduce((sum, push) => sum + (push[along] ?? 0), 0);
    const gear = clamp(axis('faster', 'slower') + pushed('faster'), -1, 1);
    const speed = this.radius_ * MOVE_SPEED * Math.pow(10, gear) * seconds;
    const right = (axis('right', 'left') + pushed('right')) * speed;
    const up = pushed('up') * speed;
    const forward = (axis('forward', 'back') + pushed('forward')) * speed;
    const lean = axis('rollRight', 'rollLeft') * ROLL_SPEED * seconds;
    const widen = axis('widen', 'narrow') * FIELD_OF_VIEW_SPEED * seconds;
    const turnRight = (axis('lookRight', 'lookLeft') + pushed('turnRight') * STICK_GAIN) * LOOK_SPEED * seconds;
    const turnUp = (axis('lookUp', 'lookDown') + pushed('turnUp') * STICK_GAIN) * LOOK_SPEED * seconds;
    let next = this.camera_;
    if (right !== 0 || up !== 0 || forward !== 0) next = move(next, right, up, forward);
    if (lean !== 0) next = roll(next, lean);
    if (widen !== 0) next = withFieldOfView(next, next.fieldOfView + widen);
    if (turnRight !== 0 || turnUp !== 0) {
      next =
        this.mode_ === 'orbit' ? orbit(next, this.distance_, turnRight, turnUp) : lookOnScreen(next, turnRight, turnUp);
    }
    if (next !== this.camera_) this.change(next, this.dirty_ ? this.eventTime_ : time);
  }

  private change(camera: Camera, time: number): void {
    if (!this.enabled_) return;
    this.camera_ = camera;
    if (!this.dirty_) this.eventTime_ = time;
    this.dirty_ = true;
    this.hooks_.changed();
    this.schedule();
  }

  private finish(time: number | null): void {
    this.dirty_ = false;
    this.moving_ = false;
    this.hooks_.restAfter(null);
    this.hooks_.send(this.camera_, false, time);
  }

  private schedule(): void {
    if (this.scheduled_) return;
    this.scheduled_ = true;
    this.hooks_.schedule();
  }
}
