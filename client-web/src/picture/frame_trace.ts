// Where the time of each frame went, from the event in the page to the picture on the screen, and that as a file for chrome://tracing
// and Perfetto. The server's marks come as durations in the frame's header; they are laid out between what the page saw, with half
// of the least round trip for each way, so no clocks are compared. Knows no DOM.

import type { Frame } from '../wire/frame.js';

const KEPT = 600; // frames
const INPUTS_KEPT = 1000;

/** A stretch of time of one frame, in milliseconds of the page's clock. */
export interface Stretch {
  readonly who: 'page' | 'line' | 'server';
  readonly what: string;
  readonly begin: number;
  readonly end: number;
}

export interface FrameTimes {
  readonly frame: Pick<Frame, 'frameId' | 'inputId' | 'width' | 'height' | 'samples'> &
    Pick<Frame, 'queueMs' | 'renderMs' | 'developMs' | 'encodeMs' | 'sendMs'>;
  readonly input: { readonly event: number; readonly sent: number } | null; // that this frame showed first
  readonly oneWay: number; // ms
  readonly arrived: number;
  readonly decoded: number;
  readonly presented: number;
}

/** The stretches of a frame, in their order. */
export function stretchesOf({ frame, input, oneWay, arrived, decoded, presented }: FrameTimes): readonly Stretch[] {
  const written = arrived - oneWay;
  const encoded = written - frame.sendMs;
  const developed = encoded - frame.encodeMs;
  const taken = developed - frame.developMs;
  const received = input === null ? null : input.sent + oneWay;
  // A pass that refines answers no input: it ended when the encoder took it.
  const begun = received === null ? taken - frame.renderMs : received + frame.queueMs;
  const rendered = begun + frame.renderMs;
  const all: Stretch[] = [];
  const add = (who: Stretch['who'], what: string, begin: number, end: number): void => {
    if (end > begin) all.push({ who, what, begin, end });
  };
  if (input !== null && received !== null) {
    add('page', 'event to message', input.event, input.sent);
    add('line', 'to the server', input.sent, received);
    add('server', 'waits to be rendered', received, begun);
  }
  add('server', 'render', begun, rendered);
  add('server', 'waits for the encoder', rendered, taken);
  add('server', 'develop', taken, developed);
  add('server', 'encode', developed, encoded);
  add('server', 'waits for the socket', encoded, written);
  add('line', 'to the page', written, arrived);
  add('page', 'decode', arrived, decoded);
  add('page', 'to the screen', decoded, presented);
  return all;
}

export class FrameTrace {
  private readonly inputs_ = new Map<number, { readonly event: number; readonly sent: number }>();
  private readonly frames_: FrameTimes[] = []; // newest last

  get frames(): readonly FrameTimes[] {
    return this.frames_;
  }

  /** A camera of an event was sent. */
  sent(inputId: number, event: number, sent: number): void {
    this.inputs_.set(inputId, { event, sent });
    if (this.inputs_.size > INPUTS_KEPT) for (const [oldest] of this.inputs_) return void this.inputs_.delete(oldest);
  }

  /** A frame is on the screen. */
  presented(frame: Frame, times: Pick<FrameTimes, 'oneWay' | 'arrived' | 'decoded' | 'presented'>): void {
    const input = this.inputs_.get(frame.inputId) ?? null;
    this.inputs_.delete(frame.inputId); // what shows it again shows nothing new
    const { frameId, inputId, width, height, samples, queueMs, renderMs, developMs, encodeMs, sendMs } = frame;
    const kept = { frameId, inputId, width, height, samples, queueMs, renderMs, developMs, encodeMs, sendMs };
    this.frames_.push({ frame: kept, input, ...times }); // not its bytes
    if (this.frames_.length > KEPT) this.frames_.shift();
  }

  /** Inputs and ids of a connection that has ended count no more. */
  reset(): void {
    this.inputs_.clear();
  }
}

/** The frames as JSON in the format of chrome://tracing: an asynchronous slice for each stretch, since frames overlap. */
export function traceFile(frames: readonly FrameTimes[]): string {
  const processes: readonly Stretch['who'][] = ['page', 'line', 'server'];
  const events: object[] = processes.map((name, pid) => ({ ph: 'M', name: 'process_name', pid, args: { name } }));
  for (const times of frames) {
    const { frameId, inputId, width, height, samples } = times.frame;
    for (const { who, what, begin, end } of stretchesOf(times)) {
      const common = { cat: 'frame', name: what, id: frameId, pid: processes.indexOf(who), tid: 0 };
      const args = { frame: frameId, input: inputId, size: `${width} x ${height}`, samples };
      events.push({ ...common, ph: 'b', ts: begin * 1000, args }, { ...common, ph: 'e', ts: end * 1000 });
    }
  }
  return JSON.stringify({ traceEvents: events, displayTimeUnit: 'ms' });
}
