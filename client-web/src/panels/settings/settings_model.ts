// What the settings panel shows and what the server has said about it. The server's echo is the truth; a value that the
// viewer has just set is shown at once and falls back to the truth when the server refuses it.

import type { SettingRow, SettingValue, SettingValues } from '../../wire/protocol.js';

interface Pending {
  readonly value: SettingValue;
  readonly inputId: number;
}

/** Equal as the server stores them: numbers as 32-bit floats. */
export const sameValue = (a: SettingValue | undefined, b: SettingValue): boolean =>
  typeof a === 'number' && typeof b === 'number' ? Math.fround(a) === Math.fround(b) : a === b;

export class SettingsModel {
  private rows_: readonly SettingRow[] = [];
  private confirmed_: Record<string, SettingValue> = {};
  private defaults_: Record<string, SettingValue> = {}; // of this server: its --set counts
  private greeted_ = false; // it has said them
  private readonly pending_ = new Map<string, Pending>();
  private readonly errors_ = new Map<string, string>();
  /** Names that this viewer has set to something else than the server's default: restored after a reconnect. */
  private readonly wanted_ = new Map<string, SettingValue>();

  setSchema(rows: readonly SettingRow[]): void {
    this.rows_ = rows.filter((row) => row.acts !== 'command');
    this.confirmed_ = {};
    this.defaults_ = {};
    this.greeted_ = false;
    this.pending_.clear();
    this.errors_.clear();
    for (const row of this.rows_) this.confirmed_[row.name] = this.defaults_[row.name] = row.default;
  }

  get rows(): readonly SettingRow[] {
    return this.rows_;
  }

  value(name: string): SettingValue | undefined {
    return this.pending_.get(name)?.value ?? this.confirmed_[name];
  }

  confirmed(name: string): SettingValue | undefined {
    return this.confirmed_[name];
  }

  error(name: string): string | null {
    return this.errors_.get(name) ?? null;
  }

  isDefault(row: SettingRow): boolean {
    return sameValue(this.value(row.name), this.default(row));
  }

  /** What this server starts with, which its operator may have set. */
  default(row: SettingRow): SettingValue {
    return this.defaults_[row.name] ?? row.default;
  }

  defaults(): SettingValues {
    return Object.fromEntries(this.rows_.map((row) => [row.name, this.default(row)]));
  }

  /** The present values of all settings. */
  values(): SettingValues {
    return this.valuesOf(this.rows_.map(({ name }) => name));
  }

  /** The present values of these settings. */
  valuesOf(names: readonly string[]): SettingValues {
    const known = names.map((name) => [name, this.value(name)] as const).filter(([, value]) => value !== undefined);
    return Object.fromEntries(known) as SettingValues;
  }

  /** The viewer sets values; they are shown until the server answers the message `inputId`. */
  change(values: SettingValues, inputId: number): void {
    for (const [name, value] of Object.entries(values)) {
      this.pending_.set(name, { value, inputId });
      this.errors_.delete(name);
      this.wanted_.set(name, value);
    }
  }

  /** The server's word on all values, in answer to message `inputId` where it answers one. */
  echo(values: SettingValues, inputId: number | null): void {
    this.confirmed_ = { ...this.confirmed_, ...values };
    if (!this.greeted_) this.defaults_ = { ...this.defaults_, ...values };
    this.greeted_ = true;
    for (const [name, pending] of this.pending_) {
      const answered = inputId !== null ? pending.inputId <= inputId : sameValue(this.confirmed_[name], pending.value);
      if (answered) this.pending_.delete(name);
    }
  }

  /** The server refused a message: its values fall back, and the message stands beside the field that it names. */
  refused(message: string, inputId: number | null): readonly string[] {
    const names = this.namesOf(message, inputId);
    const named = names.filter((name) => mentions(message, name));
    for (const name of names) this.fallBack(name);
    for (const name of named.length > 0 ? named : names) this.errors_.set(name, message);
    return names;
  }

  /** A value that this page cannot even send. */
  reject(name: string, message: string): void {
    this.errors_.set(name, message);
  }

  /** What to send after a reconnect. */
  restorable(): SettingValues {
    const known = this.rows_.filter((row) => this.wanted_.has(row.name));
    return Object.fromEntries(known.map((row) => [row.name, this.wanted_.get(row.name)!]));
  }

  private fallBack(name: string): void {
    this.pending_.delete(name);
    const truth = this.confirmed_[name];
    if (truth === undefined || sameValue(this.defaults_[name], truth)) {
      this.wanted_.delete(name);
    } else {
      this.wanted_.set(name, truth);
    }
  }

  /** Names of the message that was refused: by its id, else those that the text mentions, else the oldest one's. */
  private namesOf(message: string, inputId: number | null): readonly string[] {
    const pending = [...this.pending_];
    if (inputId !== null) return pending.filter(([, entry]) => entry.inputId === inputId).map(([name]) => name);
    const mentioned = pending.filter(([name]) => mentions(message, name)).map(([name]) => name);
    if (mentioned.length > 0) return mentioned;
    const oldest = Math.min(...pending.map(([, entry]) => entry.inputId));
    return pending.filter(([, entry]) => entry.inputId === oldest).map(([name]) => name);
  }
}

const mentions = (message: string, name: string): boolean => new RegExp(`\\b${name}\\b`).test(message);
