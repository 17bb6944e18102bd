// Whom a key belongs to: the flight, a shortcut of the page, or the control that has the focus. Knows no DOM.

import type { HeldAction } from './camera_controller.js';

/** By `KeyboardEvent.code`: the place of a key on a US keyboard. */
export const HELD_KEYS: Readonly<Record<string, HeldAction>> = {
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

/** What has the focus, as far as keys are concerned. */
export type FocusedControl =
  | 'none' // the picture, or nothing
  | 'dialog' // or an open menu: takes every key
  | 'text' // numbers, choices, words: takes every key that is no function key
  | 'slider' // also a switch: Space and the arrows
  | 'button'; // Space and Enter

export interface KeyPress {
  readonly code: string;
  readonly plain: boolean; // without Control, Alt or Meta
  readonly control: FocusedControl;
  readonly flying: boolean; // another key of flying is held
}

export type KeyUse = 'page' | 'flight' | 'control';

const isFunctionKey = (code: string): boolean => /^F\d+$/.test(code);
const isEnter = (code: string): boolean => code === 'Enter' || code === 'NumpadEnter';
const isArrow = (code: string): boolean => code.startsWith('Arrow');

/** Whether the focused control wants the key. While flying, Space and Enter do not press the last button. */
function wantedByControl({ code, control, flying }: KeyPress): boolean {
  switch (control) {
    case 'none':
      return false;
    case 'dialog':
    case 'text':
      return true;
    case 'slider':
      return (code === 'Space' && !flying) || isArrow(code);
    case 'button':
      return (code === 'Space' || isEnter(code)) && !flying;
  }
}

/**
 * `page`: one of its shortcuts, if there is one for the key. `flight`: the key moves the camera, or is swallowed for its
 * sake. `control`: the browser does what it always does.
 */
export function keyUse(press: KeyPress): KeyUse {
  if (!press.plain || press.control === 'dialog') return 'control';
  if (isFunctionKey(press.code)) return 'page';
  if (wantedByControl(press)) return 'control';
  if (HELD_KEYS[press.code] !== undefined) return 'flight';
  return press.flying && isEnter(press.code) ? 'flight' : 'page';
}
