// What steers beside keys and drags: a gamepad, the mouse that the page was given, and a stick on the screen for thumbs.

import { el } from '../page/dom.js';
import type { CameraController } from './camera_controller.js';
import { pressedButtons, pushOf, type PadActions } from './gamepad.js';
import './steering.css';

/** Asks gamepads once an animation frame, while there are any and the window has the focus. */
export function attachGamepads(controller: CameraController, actions: PadActions): void {
  let pressed: ReadonlySet<number> = new Set();
  let asking = false;
  const ask = (time: number): void => {
    const pad = [...navigator.getGamepads()].find((one) => one !== null && one.connected) ?? null;
    asking = pad !== null;
    const heard = document.hasFocus() ? pad : null;
    controller.push('gamepad', heard === null ? null : pushOf(heard), time);
    if (heard !== null) pressed = pressedButtons(heard, pressed, actions);
    if (asking) requestAnimationFrame(ask);
  };
  window.addEventListener('gamepadconnected', () => {
    if (!asking) requestAnimationFrame(ask);
    asking = true;
  });
}

/** The mouse looks without a button until Escape, or until this is called again. */
export class MouseLock {
  constructor(
    private readonly canvas_: HTMLCanvasElement,
    controller: CameraController,
    private readonly notice_: (text: string) => void,
  ) {
    document.addEventListener('pointerlockchange', () => {
      if (this.locked) notice_('The mouse looks around. Escape or L gives it back.');
    });
    document.addEventListener('pointerlockerror', () => this.refused());
    canvas_.addEventListener('mousemove', (event) => {
      if (this.locked) controller.turn(event.movementX, event.movementY, false, event.timeStamp);
    });
  }

  toggle(): void {
    if (this.locked) return document.exitPointerLock();
    this.canvas_.focus({ preventScroll: true });
    if (typeof this.canvas_.requestPointerLock !== 'function') return this.refused();
    const asked: unknown = this.canvas_.requestPointerLock();
    if (asked instanceof Promise) asked.catch(() => undefined); // pointerlockerror tells it
  }

  private get locked(): boolean {
    return document.pointerLockElement === this.canvas_;
  }

  private refused(): void {
    this.notice_('The browser does not give the mouse to this page. Drag on the picture instead.');
  }
}

/** A stick for a thumb, where there is no finer pointer: moves as W A S D do. */
export function thumbStick(controller: CameraController): HTMLElement {
  const knob = el('span', { class: 'thumb-knob' });
  const stick = el('div', { class: 'thumb-stick', 'aria-hidden': 'true' }, knob); // who hears the page has W A S D
  const show = (x: number, y: number): void => {
    knob.style.setProperty('--x', String(x));
    knob.style.setProperty('--y', String(y));
  };
  const move = (event: PointerEvent): void => {
    if (!stick.classList.contains('held')) return;
    const box = stick.getBoundingClientRect();
    const across = (event.clientX - box.left) / (box.width / 2) - 1;
    const down = (event.clientY - box.top) / (box.height / 2) - 1;
    const length = Math.max(1, Math.hypot(across, down));
    show(across / length, down / length);
    controller.push('thumb', { right: across / length, forward: -down / length }, event.timeStamp);
  };
  const end = (event: PointerEvent): void => {
    stick.classList.remove('held');
    show(0, 0);
    controller.push('thumb', null, event.timeStamp);
  };
  stick.addEventListener('pointerdown', (event) => {
    stick.setPointerCapture(event.pointerId);
    stick.classList.add('held');
    move(event);
  });
  stick.addEventListener('pointermove', move);
  for (const name of ['pointerup', 'pointercancel'] as const) stick.addEventListener(name, end);
  return stick;
}
