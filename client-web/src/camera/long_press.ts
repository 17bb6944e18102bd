// Tells a finger that rests on one place from one that drags or pinches. Knows no DOM; the timer comes from outside.

export const LONG_PRESS_MS = 500;
const REACH = 10; // CSS pixels a resting finger may wander

export interface LongPressHooks {
  /** One call of `elapsed` after `ms`, replacing an earlier one; null cancels. */
  after(ms: number | null): void;
  pressed(x: number, y: number): void;
}

export class LongPress {
  private begin_: { readonly x: number; readonly y: number } | null = null;
  private fingers_ = 0;

  constructor(private readonly hooks_: LongPressHooks) {}

  down(x: number, y: number): void {
    this.fingers_ += 1;
    if (this.fingers_ > 1) return this.cancel();
    this.begin_ = { x, y };
    this.hooks_.after(LONG_PRESS_MS);
  }

  move(x: number, y: number): void {
    if (this.begin_ !== null && Math.hypot(x - this.begin_.x, y - this.begin_.y) > REACH) this.cancel();
  }

  up(): void {
    this.fingers_ = Math.max(0, this.fingers_ - 1);
    this.cancel();
  }

  /** The time that `after` asked for. */
  elapsed(): void {
    const begin = this.begin_;
    this.begin_ = null;
    if (begin !== null) this.hooks_.pressed(begin.x, begin.y);
  }

  private cancel(): void {
    this.begin_ = null;
    this.hooks_.after(null);
  }
}
