// A line of given delay, rate and stalls between a viewer and a server on this machine: a relay of TCP connections.
import { connect, createServer } from 'node:net';

/** What lines are like: `delayMs` each way, `bytesPerSecond` to the viewer, a stall of `stallMs` about every `stallEveryMs`. */
export const LINES = {
  free: { delayMs: 0 },
  '300 ms': { delayMs: 150 },
  '2 Mbit/s 50 ms': { delayMs: 25, bytesPerSecond: 250e3 },
  lossy: { delayMs: 25, stallEveryMs: 1000, stallMs: 250 },
};

const QUEUE_BYTES = 128 * 1024; // that wait at the line's entrance: a router's buffer
const SEGMENT_BYTES = 1448;

/** Times between stalls vary evenly from half to one and a half of the mean, the same in every run. */
function* stallTimes(everyMs) {
  let seed = 1;
  for (let at = 0; ; ) {
    seed = (seed * 48271) % 2147483647;
    at += everyMs * (0.5 + seed / 2147483647);
    yield at;
  }
}

/** One direction: bytes come out in order, not before their time. */
class Direction {
  constructor(from, to, { delayMs, bytesPerSecond = Infinity, stallEveryMs = 0, stallMs = 0 }, counted) {
    this.line = { delayMs, bytesPerSecond, stallMs };
    this.to = to;
    this.from = from;
    this.counted = counted;
    this.free = 0; // when the line has sent what was put into it
    this.last = 0; // when the newest byte arrives
    this.waiting = []; // [time, bytes]
    this.entrance = []; // [when they are on their way, bytes]
    this.queued = 0; // bytes at the entrance
    this.held = null;
    this.timer = null;
    this.begin = performance.now();
    this.stalls = stallEveryMs > 0 ? stallTimes(stallEveryMs) : null;
    this.nextStall = this.stalls?.next().value ?? Infinity;
    from.on('data', (data) => this.take(data));
    from.on('end', () => this.put(null));
  }

  take(data) {
    this.counted(data.length);
    for (let at = 0; at < data.length; at += SEGMENT_BYTES) this.put(data.subarray(at, at + SEGMENT_BYTES));
    if (this.held === null) this.hold();
  }

  /** No more is taken while the entrance is full. What is on its way does not count: a long line holds as much as it carries. */
  hold() {
    const now = performance.now();
    this.held = null;
    while (this.entrance.length > 0 && this.entrance[0][0] <= now) this.queued -= this.entrance.shift()[1];
    if (this.queued <= QUEUE_BYTES) return void this.from.resume();
    this.from.pause();
    this.held = setTimeout(() => this.hold(), Math.max(1, this.entrance[0][0] - now));
  }

  put(bytes) {
    const now = performance.now();
    this.free = Math.max(this.free, now) + ((bytes?.length ?? 0) / this.line.bytesPerSecond) * 1000;
    let arrival = this.free + this.line.delayMs;
    while (arrival - this.begin > this.nextStall) {
      arrival = Math.max(arrival, this.begin + this.nextStall + this.line.stallMs);
      this.nextStall = this.stalls.next().value;
    }
    this.last = Math.max(this.last, arrival); // what comes behind a stall waits for it
    this.waiting.push([this.last, bytes]);
    this.queued += bytes?.length ?? 0;
    this.entrance.push([this.last - this.line.delayMs, bytes?.length ?? 0]);
    if (this.timer === null) this.schedule();
  }

  schedule() {
    const wait = this.waiting[0][0] - performance.now();
    if (wait <= 0.5) return this.deliver();
    this.timer = setTimeout(() => this.deliver(), wait);
  }

  deliver() {
    this.timer = null;
    const now = performance.now() + 0.5;
    while (this.waiting.length > 0 && this.waiting[0][0] <= now) {
      const [, bytes] = this.waiting.shift();
      if (bytes === null) this.to.end();
      else if (!this.to.destroyed) this.to.write(bytes);
    }
    if (this.waiting.length > 0) this.schedule();
  }
}

/** A relay to `port` on this machine. `received` counts the bytes to viewers. */
export class Line {
  received = 0;

  static async open(port, line) {
    const relay = new Line();
    relay.server = createServer({ noDelay: true }, (viewer) => {
      const server = connect({ port, host: '127.0.0.1', noDelay: true });
      const down = new Direction(server, viewer, line, (bytes) => (relay.received += bytes));
      const up = new Direction(viewer, server, { delayMs: line.delayMs }, () => undefined);
      for (const [one, other] of [[viewer, server], [server, viewer]]) {
        one.on('error', () => other.destroy());
        one.on('close', () => relay.#leave(other, one === server ? down : up, line.delayMs + 100));
      }
    });
    await new Promise((ready) => relay.server.listen(0, '127.0.0.1', ready));
    relay.port = relay.server.address().port;
    return relay;
  }

  /** Ends the other side once what was on its way has come. */
  #leave(other, direction, waitMs) {
    setTimeout(() => (direction.waiting.length > 0 ? this.#leave(other, direction, 50) : other.destroy()), waitMs);
  }

  close() {
    this.server.close();
  }
}
