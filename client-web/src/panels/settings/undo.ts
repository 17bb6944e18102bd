// The values that settings had before the viewer's last changes. Knows no DOM.

import type { SettingValues } from '../../wire/protocol.js';

const MOST = 50;
const TOGETHER_MS = 1000; // changes of the same settings within this are one, as while a slider is drawn

export class UndoStack {
  private readonly before_: SettingValues[] = [];
  private names_ = '';
  private time_ = -Infinity;

  get size(): number {
    return this.before_.length;
  }

  /** Settings are changed that had the values `before`. `time`: ms. */
  record(before: SettingValues, time: number): void {
    const names = Object.keys(before).sort().join();
    const together = names === this.names_ && time - this.time_ < TOGETHER_MS;
    this.names_ = names;
    this.time_ = time;
    if (together || names === '') return;
    this.before_.push(before);
    if (this.before_.length > MOST) this.before_.shift();
  }

  /** What to set; null where nothing was changed. */
  pop(): SettingValues | null {
    this.names_ = '';
    return this.before_.pop() ?? null;
  }
}
