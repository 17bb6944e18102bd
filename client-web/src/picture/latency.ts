// Measurements of the running stream: motion to photon per input, intervals between frames, bytes per second.

/** The newest `capacity` numbers. */
export class Window {
  private readonly values_: number[] = [];

  constructor(private readonly capacity_: number) {}

  push(value: number): void {
    this.values_.push(value);
    if (this.values_.length > this.capacity_) this.values_.shift();
  }

  clear(): void {
    this.values_.length = 0;
  }

  get values(): readonly number[] {
    return this.values_;
  }

  /** Nearest-rank quantile, `share` in [0, 1]; null when empty. */
  quantile(share: number): number | null {
    if (this.values_.length === 0) return null;
    const sorted = [...this.values_].sort((a, b) => a - b);
    const rank = Math.ceil(share * sorted.length) - 1;
    return sorted[Math.min(Math.max(rank, 0), sorted.length - 1)] ?? null;
  }
}

/** Pairs inputs with the first picture that shows them. Times are performance.now() milliseconds. */
export class MotionToPhoton {
  private readonly pending_: { inputId: number; time: number }[] = [];
  readonly window: Window;

  constructor(capacity: number) {
    this.window = new Window(capacity);
  }

  /** `time`: when the event happened, not when it was sent. */
  sent(inputId: number, time: number): void {
    this.pending_.push({ inputId, time });
    if (this.pending_.length > 1000) this.pending_.shift();
  }

  /** Milliseconds from the input to this picture, or null when the input has been seen before or was no motion. */
  presented(inputId: number, time: number): number | null {
    let result: number | null = null;
    while (this.pending_.length > 0 && this.pending_[0]!.inputId <= inputId) {
      const input = this.pending_.shift()!;
      if (input.inputId === inputId) result = time - input.time;
    }
    if (result !== null) this.window.push(result);
    return result;
  }

  /** Inputs on their way are lost with the connection. */
  reset(): void {
    this.pending_.length = 0;
  }
}

/** Events and bytes per second over the last `spanMs` milliseconds. */
export class RateMeter {
  private readonly entries_: { time: number; amount: number }[] = [];

  constructor(private readonly spanMs_: number) {}

  push(time: number, amount: number): void {
    this.entries_.push({ time, amount });
    this.trim(time);
  }

  events(now: number): number {
    this.trim(now);
    return (this.entries_.length * 1000) / this.spanMs_;
  }

  amount(now: number): number {
    this.trim(now);
    return (this.entries_.reduce((sum, entry) => sum + entry.amount, 0) * 1000) / this.spanMs_;
  }

  private trim(now: number): void {
    while (this.entries_.length > 0 && this.entries_[0]!.time <= now - this.spanMs_) this.entries_.shift();
  }
}
