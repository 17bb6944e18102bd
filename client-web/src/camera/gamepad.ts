// A gamepad with the standard layout of browsers, as pushes of its sticks and presses of its buttons. Knows no DOM.

import type { Push } from './camera_controller.js';

const DEAD = 0.15; // a stick at rest is not quite in its middle

/** What a gamepad says, as navigator.getGamepads() has it. */
export interface PadState {
  readonly axes: readonly number[];
  readonly buttons: readonly { readonly value: number; readonly pressed: boolean }[];
}

/** Finer near the middle; nothing within the dead zone. */
export function eased(value: number): number {
  const beyond = Math.min(1, (Math.abs(value) - DEAD) / (1 - DEAD));
  return beyond <= 0 || !Number.isFinite(beyond) ? 0 : Math.sign(value) * beyond * beyond;
}

/** Left stick moves, right one looks, triggers go down and up, shoulders slower and faster. Null: all is at rest. */
export function pushOf({ axes, buttons }: PadState): Push | null {
  const axis = (index: number): number => eased(axes[index] ?? 0);
  const pressed = (index: number): number => Number(buttons[index]?.pressed ?? false);
  const push: Required<Push> = {
    right: axis(0),
    forward: -axis(1),
    turnRight: axis(2),
    turnUp: -axis(3),
    up: eased(buttons[7]?.value ?? 0) - eased(buttons[6]?.value ?? 0),
    faster: pressed(5) - pressed(4),
  };
  const { faster, ...moves } = push;
  return Object.values(moves).some((value) => value !== 0) ? { ...moves, faster } : null;
}

/** By the number of the button in the standard layout. */
export type PadActions = Readonly<Record<number, () => void>>;

/** Calls the action of each button that is pressed now and was not before; answers which are. */
export function pressedButtons(pad: PadState, before: ReadonlySet<number>, actions: PadActions): ReadonlySet<number> {
  const now = new Set(Object.keys(actions).map(Number).filter((index) => pad.buttons[index]?.pressed));
  for (const index of now) if (!before.has(index)) actions[index]?.();
  return now;
}
