// What becomes of each frame from the wire: exactly one acknowledgement, shown or not, and its place in the statistics.
// Knows no DOM and no socket.

import type { Presentation } from './picture/display.js';
import type { StreamMeter } from './picture/stream_meter.js';
import { isVideo, type Frame } from './wire/frame.js';
import { LONGEST_PRESENTED_MS } from './wire/limits.js';
import type { ViewerState } from './viewer_state.js';

export interface FrameHooks {
  /** Decodes and shows it; answers by `presented` or `dropped`, unless the connection ends. */
  show(frame: Frame): void;
  /**
   * `presentedMs`: motion to photon; null where it shows no new input or was not shown. `shownMs`: from its arrival until
   * it was shown or dropped.
   */
  acknowledge(frameId: number, presentedMs: number | null, shownMs: number | null, undecodable: boolean): void;
  /** Of a video those that build on it are not decodable either, and the server begins it anew; told of others alone. */
  undecodable(frame: Frame): void;
  /** A picture of a video is not shown: those that build on it cannot be. */
  skipped(): void;
}

export class Frames {
  private readonly arrivals_ = new Map<number, number>(); // frame id: ms; of frames that are not acknowledged yet

  constructor(
    private readonly state_: Pick<ViewerState, 'lastFrame' | 'framesPresented' | 'framesDropped'>,
    private readonly meter_: StreamMeter,
    private readonly hooks_: FrameHooks,
  ) {}

  /** `hidden`: the frame shows another scene than the one that is looked at. `time`: of its arrival, ms. */
  arrived(frame: Frame, hidden: boolean, time: number): void {
    this.arrivals_.set(frame.frameId, time);
    if (!hidden) return this.hooks_.show(frame);
    const video = isVideo(frame.codec);
    if (video) this.hooks_.skipped();
    this.dropped(frame, video ? 'undecodable' : 'newer', time);
  }

  presented({ frame, decodeMs, time }: Presentation): void {
    const arrived = this.arrivals_.get(frame.frameId) ?? time;
    const latency = this.meter_.presented(frame, decodeMs, time, arrived);
    this.acknowledge(frame.frameId, latency !== null && latency <= LONGEST_PRESENTED_MS ? latency : null, time);
    this.state_.lastFrame = frame;
    this.state_.framesPresented += 1;
  }

  dropped(frame: Frame, reason: 'newer' | 'undecodable', time: number): void {
    this.state_.framesDropped += 1;
    this.acknowledge(frame.frameId, null, time, reason === 'undecodable');
    if (reason === 'undecodable' && !isVideo(frame.codec)) this.hooks_.undecodable(frame);
  }

  /** A part of a picture was taken; the last one is told by what becomes of the picture. */
  partTaken(frame: Frame, time: number): void {
    this.acknowledge(frame.frameId, null, time);
  }

  /** The connection has ended: frame ids begin anew with the next one. */
  reset(): void {
    this.arrivals_.clear();
  }

  private acknowledge(frameId: number, presentedMs: number | null, time: number, undecodable = false): void {
    const arrival = this.arrivals_.get(frameId);
    this.arrivals_.delete(frameId);
    const shownMs = arrival === undefined ? null : Math.min(Math.max(0, time - arrival), LONGEST_PRESENTED_MS);
    this.hooks_.acknowledge(frameId, presentedMs, shownMs, undecodable);
  }
}
