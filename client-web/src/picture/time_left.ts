// How long until the picture has all its samples. Knows no DOM.

const SHORTEST_LOOK = 500; // ms of refining before anything is said

interface Progress {
  readonly time: number; // ms
  readonly samples: number;
}

export class TimeLeft {
  private first_: Progress | null = null;
  private last_: Progress | null = null;

  /** A picture with `samples` is shown since `time`; fewer than before: another picture has begun. */
  shown(samples: number, time: number): void {
    if (this.last_ === null || samples < this.last_.samples) this.first_ = { time, samples };
    this.last_ = { time, samples };
  }

  /** Milliseconds until `target` samples; null where that is not known. */
  until(target: number, now: number): number | null {
    if (this.first_ === null || this.last_ === null || target <= this.last_.samples) return null;
    const took = this.last_.time - this.first_.time;
    const more = this.last_.samples - this.first_.samples;
    if (took < SHORTEST_LOOK || more <= 0) return null;
    return Math.max(0, ((target - this.last_.samples) * took) / more - (now - this.last_.time));
  }
}

/** In the words of somebody who waits: "5 s", "3 min", "2 h". */
export function waitText(ms: number): string {
  const seconds = Math.max(1, Math.round(ms / 1000));
  if (seconds < 90) return `${seconds} s`;
  return seconds < 90 * 60 ? `${Math.round(seconds / 60)} min` : `${Math.round(seconds / 3600)} h`;
}
