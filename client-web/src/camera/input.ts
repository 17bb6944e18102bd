// Mouse, touch, pen and keyboard on the picture, handed on as the controller's terms.

import type { CameraController } from './camera_controller.js';
import { HELD_KEYS, keyUse, type FocusedControl } from './key_use.js';
import { LongPress } from './long_press.js';

const SLIDERS: readonly string[] = ['checkbox', 'radio', 'range'];
const LINE_PIXELS = 33; // a wheel event in lines: three lines are about one notch

function controlOf(target: EventTarget | null): FocusedControl {
  if (!(target instanceof Element)) return 'none';
  if (target.closest('dialog, [role="menu"]') || document.querySelector('dialog[open]') !== null) return 'dialog';
  if (target.closest('[role="slider"]') !== null) return 'slider';
  const field = target.closest('input, select, textarea');
  if (field instanceof HTMLInputElement && SLIDERS.includes(field.type)) return 'slider';
  if (field !== null) return 'text';
  return target.closest('button, summary, a') === null ? 'none' : 'button';
}

/** Held keys of flying, as the browser tells of them; keys that it does not tell of any more are let go. */
class Keyboard {
  private away_ = false; // the window lost the focus: what is pressed now is never said to be let go
  private readonly swallowed_ = new Set<string>(); // codes whose keyup shall press no button either

  constructor(
    private readonly controller_: CameraController,
    private readonly shortcuts_: Readonly<Record<string, () => void>>,
  ) {}

  /** The window has the focus again. */
  back(): void {
    this.away_ = false;
  }

  leave(event: Event): void {
    this.away_ = true;
    this.controller_.releaseAll(event.timeStamp);
  }

  down(event: KeyboardEvent): void {
    // macOS swallows the keyup of what is held while Command is.
    if (event.key === 'Meta' || event.code.startsWith('Meta')) return this.controller_.releaseAll(event.timeStamp);
    const plain = !event.ctrlKey && !event.metaKey && !event.altKey;
    const { flying } = this.controller_;
    const use = keyUse({ code: event.code, plain, control: controlOf(event.target), flying });
    if (use === 'control') return;
    const shortcut = this.shortcuts_[event.code] ?? this.shortcuts_[event.key];
    if (use === 'page') {
      if (shortcut === undefined) return;
      event.preventDefault();
      if (!event.repeat) shortcut();
      return;
    }
    if (!/^(Key|Shift)/.test(event.code)) {
      event.preventDefault();
      this.swallowed_.add(event.code);
    }
    const action = HELD_KEYS[event.code];
    if (action !== undefined && !this.away_) this.controller_.press(action, event.timeStamp);
  }

  up(event: KeyboardEvent): void {
    if (event.key === 'Meta' || event.code.startsWith('Meta')) this.controller_.releaseAll(event.timeStamp);
    if (this.swallowed_.delete(event.code)) event.preventDefault(); // Firefox presses a button by its keyup
    const action = HELD_KEYS[event.code];
    if (action !== undefined) this.controller_.release(action, event.timeStamp);
  }
}

export function attachKeyboard(controller: CameraController, shortcuts: Readonly<Record<string, () => void>>): void {
  const keyboard = new Keyboard(controller, shortcuts);
  window.addEventListener('keydown', (event) => keyboard.down(event));
  window.addEventListener('keyup', (event) => keyboard.up(event));
  window.addEventListener('blur', (event) => keyboard.leave(event));
  window.addEventListener('focus', () => keyboard.back());
  window.addEventListener('pointerdown', () => keyboard.back(), { capture: true });
  document.addEventListener('visibilitychange', (event) => {
    if (document.hidden) controller.releaseAll(event.timeStamp);
  });
}

interface Pointer {
  x: number;
  y: number;
  readonly does: 'turn' | 'pan' | 'light'; // pan: right or middle button, or shift; light: Alt
}

/** Pointers that are down on the picture, at their last known places (CSS pixels). */
class PointerTracker {
  private readonly pointers_ = new Map<number, Pointer>();

  constructor(
    private readonly canvas_: HTMLCanvasElement,
    private readonly controller_: CameraController,
    private readonly turnLight_: (dx: number) => void,
  ) {}

  down(event: PointerEvent): void {
    if (document.pointerLockElement !== null) return; // the mouse looks already, and cannot be captured
    this.canvas_.focus({ preventScroll: true });
    this.canvas_.setPointerCapture(event.pointerId);
    const pan = event.button === 1 || event.button === 2 || event.shiftKey;
    const does = pan ? 'pan' : event.altKey ? 'light' : 'turn';
    this.pointers_.set(event.pointerId, { x: event.clientX, y: event.clientY, does });
    this.canvas_.classList.add('dragging');
  }

  move(event: PointerEvent): void {
    const pointer = this.pointers_.get(event.pointerId);
    if (pointer === undefined) return;
    const dx = event.clientX - pointer.x;
    const dy = event.clientY - pointer.y;
    const others = [...this.pointers_].filter(([id]) => id !== event.pointerId).map(([, other]) => other);
    const other = others[0];
    if (other !== undefined) this.pinch(pointer, other, event);
    else if (pointer.does === 'light') this.turnLight_(dx);
    else if (pointer.does === 'pan') this.controller_.pan(dx, dy, event.timeStamp);
    else this.controller_.turn(dx, dy, event.pointerType !== 'mouse', event.timeStamp);
    pointer.x = event.clientX;
    pointer.y = event.clientY;
  }

  up(event: PointerEvent): void {
    if (!this.pointers_.delete(event.pointerId) || this.pointers_.size > 0) return;
    this.canvas_.classList.remove('dragging');
    this.controller_.end(event.timeStamp);
  }

  /** Two fingers: their middle pans, their distance zooms. */
  private pinch(pointer: Pointer, other: Pointer, event: PointerEvent): void {
    const before = Math.hypot(pointer.x - other.x, pointer.y - other.y);
    const after = Math.hypot(event.clientX - other.x, event.clientY - other.y);
    this.controller_.pan((event.clientX - pointer.x) / 2, (event.clientY - pointer.y) / 2, event.timeStamp);
    if (before > 1 && after > 1) this.controller_.pinch(after / before, event.timeStamp);
  }
}

export interface PictureHooks {
  /** A double click or a long press, in CSS pixels of the window. */
  pick(x: number, y: number): void;
  /** A drag with Alt to the right, in CSS pixels. */
  turnLight(dx: number): void;
}

export function attachPointers(canvas: HTMLCanvasElement, controller: CameraController, hooks: PictureHooks): void {
  const { pick } = hooks;
  const tracker = new PointerTracker(canvas, controller, (dx) => hooks.turnLight(dx));
  canvas.addEventListener('pointerdown', (event) => tracker.down(event));
  canvas.addEventListener('pointermove', (event) => tracker.move(event));
  canvas.addEventListener('pointerup', (event) => tracker.up(event));
  canvas.addEventListener('pointercancel', (event) => tracker.up(event));
  canvas.addEventListener('dblclick', (event) => pick(event.clientX, event.clientY));
  attachLongPress(canvas, pick);
  canvas.addEventListener('contextmenu', (event) => event.preventDefault());
  canvas.addEventListener(
    'wheel',
    (event) => {
      event.preventDefault();
      const unit =
        event.deltaMode === WheelEvent.DOM_DELTA_LINE
          ? LINE_PIXELS
          : event.deltaMode === WheelEvent.DOM_DELTA_PAGE
            ? 300
            : 1;
      controller.wheel(event.deltaY * unit, event.timeStamp);
    },
    { passive: false },
  );
}

function attachLongPress(canvas: HTMLCanvasElement, pick: (x: number, y: number) => void): void {
  let timer = 0;
  const press: LongPress = new LongPress({
    after: (ms) => {
      window.clearTimeout(timer);
      if (ms !== null) timer = window.setTimeout(() => press.elapsed(), ms);
    },
    pressed: pick,
  });
  const byTouch = (handle: (event: PointerEvent) => void) => (event: PointerEvent) => {
    if (event.pointerType !== 'mouse') handle(event);
  };
  canvas.addEventListener(
    'pointerdown',
    byTouch((event) => press.down(event.clientX, event.clientY)),
  );
  canvas.addEventListener(
    'pointermove',
    byTouch((event) => press.move(event.clientX, event.clientY)),
  );
  canvas.addEventListener(
    'pointerup',
    byTouch(() => press.up()),
  );
  canvas.addEventListener(
    'pointercancel',
    byTouch(() => press.up()),
  );
}
