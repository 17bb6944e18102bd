// Mouse, touch, pen and keyboard on the picture, handed on as the controller's terms.

import type { CameraController, HeldAction } from './camera_controller.js';
import { LongPress } from './long_press.js';

const HELD_KEYS: Readonly<Record<string, HeldAction>> = {
  KeyW: 'forward',
  KeyS: 'back',
  KeyA: 'left',
  KeyD: 'right',
  KeyQ: 'rollLeft',
  KeyE: 'rollRight',
  KeyT: 'widen',
  KeyG: 'narrow',
  Space: 'faster',
  ShiftLeft: 'slower',
  ShiftRight: 'slower',
  ArrowLeft: 'lookLeft',
  ArrowRight: 'lookRight',
  ArrowUp: 'lookUp',
  ArrowDown: 'lookDown',
};

const LINE_PIXELS = 33; // a wheel event in lines: three lines are about one notch

/** Whether a key pressed here belongs to the control that has the focus. */
function belongsToControl(event: KeyboardEvent): boolean {
  const target = event.target;
  if (!(target instanceof Element)) return false;
  if (target.closest('dialog, [role="menu"]')) return true;
  const field = target.closest('input, select, textarea');
  if (field instanceof HTMLInputElement && (field.type === 'checkbox' || field.type === 'range')) {
    return event.code === 'Space' || event.code.startsWith('Arrow');
  }
  if (field !== null) return true;
  return event.code === 'Space' && target.closest('button, summary, a') !== null;
}

export function attachKeyboard(controller: CameraController, shortcuts: Readonly<Record<string, () => void>>): void {
  window.addEventListener('keydown', (event) => {
    const plain = !event.ctrlKey && !event.metaKey && !event.altKey;
    const shortcut = shortcuts[event.code] ?? shortcuts[event.key];
    const functionKey = /^F\d+$/.test(event.code);
    if (shortcut !== undefined && plain && (functionKey || !belongsToControl(event))) {
      event.preventDefault();
      if (!event.repeat) shortcut();
      return;
    }
    const action = HELD_KEYS[event.code];
    if (action === undefined || !plain || belongsToControl(event)) return;
    if (event.code === 'Space' || event.code.startsWith('Arrow')) event.preventDefault();
    controller.press(action, event.timeStamp);
  });
  window.addEventListener('keyup', (event) => {
    const action = HELD_KEYS[event.code];
    if (action !== undefined) controller.release(action, event.timeStamp);
  });
  window.addEventListener('blur', (event) => controller.releaseAll(event.timeStamp));
}

interface Pointer {
  x: number;
  y: number;
  readonly pan: boolean; // right or middle button, or shift
}

/** Pointers that are down on the picture, at their last known places (CSS pixels). */
class PointerTracker {
  private readonly pointers_ = new Map<number, Pointer>();

  constructor(
    private readonly canvas_: HTMLCanvasElement,
    private readonly controller_: CameraController,
  ) {}

  down(event: PointerEvent): void {
    this.canvas_.focus({ preventScroll: true });
    this.canvas_.setPointerCapture(event.pointerId);
    const pan = event.button === 1 || event.button === 2 || event.shiftKey;
    this.pointers_.set(event.pointerId, { x: event.clientX, y: event.clientY, pan });
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
    else if (pointer.pan) this.controller_.pan(dx, dy, event.timeStamp);
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
    if (before > 1 && after > 1) this.controller_.zoom(after / before, event.timeStamp);
  }
}

/** `pick` gets the place, in CSS pixels of the window, of a double click or a long press. */
export function attachPointers(
  canvas: HTMLCanvasElement,
  controller: CameraController,
  pick: (x: number, y: number) => void,
): void {
  const tracker = new PointerTracker(canvas, controller);
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
