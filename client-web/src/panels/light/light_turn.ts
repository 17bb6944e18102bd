// Turns the surroundings from the picture: by a drag, whose light on the scene follows the pointer, or by a key. Knows no
// DOM.

import type { SettingRow, SettingValue, SettingValues } from '../../wire/protocol.js';
import { lightWithoutUse } from './light_rows.js';
import { turnedTo } from './light_scale.js';

const ROW = 'environmentRotation';
const SUN_ROW = 'sunAzimuth';
const PER_HEIGHT = 180; // degrees for a drag over the whole height
export const KEY_TURN = 15; // degrees

export interface LightTurnHooks {
  rows(): readonly SettingRow[];
  value(name: string): SettingValue | undefined;
  set(values: SettingValues): void;
  /** Why nothing turns. */
  notice(text: string): void;
}

export class LightTurn {
  private rest_ = 0; // degrees, less than one, that a drag has yet to turn
  private told_ = '';

  constructor(private readonly hooks_: LightTurnHooks) {}

  /** A drag to the right by CSS pixels, in a picture that is so high. */
  drag(pixels: number, height: number): void {
    this.rest_ += (pixels * PER_HEIGHT) / Math.max(1, height);
    const whole = Math.trunc(this.rest_);
    this.rest_ -= whole;
    if (whole !== 0) this.by(whole);
  }

  /** The sun goes along, so that what is around and what shines stay as they are to each other. */
  by(degrees: number): void {
    const values = { ...this.turned(ROW, degrees), ...(this.hooks_.value('sun') === true ? this.turned(SUN_ROW, degrees) : {}) };
    if (Object.keys(values).length === 0) return this.tell(this.reason() ?? 'This server does not turn surroundings.');
    this.told_ = '';
    this.hooks_.set(values);
  }

  private reason(): string | null {
    return lightWithoutUse(ROW, (name) => this.hooks_.value(name));
  }

  /** Nothing where the setting lacks or turning it changes nothing. */
  private turned(name: string, degrees: number): SettingValues {
    const row = this.hooks_.rows().find((one) => one.name === name);
    const value = this.hooks_.value(name);
    if (row === undefined || typeof value !== 'number' || (name === ROW && this.reason() !== null)) return {};
    return { [name]: turnedTo(row, value + degrees) };
  }

  /** Once for a drag that goes on. */
  private tell(reason: string): void {
    if (reason !== this.told_) this.hooks_.notice(reason);
    this.told_ = reason;
  }
}
