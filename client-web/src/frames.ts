// What becomes of each frame from the wire: exactly one acknowledgement, shown or not, and its place in the statistics.
// Knows no DOM and no socket.

import type { Presentation } from './picture/display.js';
import type { StreamMeter } from './picture/stream_meter.js';
import type { Frame } from './wire/frame.js';
import { LONGEST_PRESENTED_MS } from './wire/limits.js';
import type { ViewerState } from './viewer_state.js';

export interface FrameHooks {
  /** Decodes and shows it; answers by `presented` or `dropped`, unless the connection ends. */
  show(frame: Frame): void;
  /** `presentedMs`: motion to photon; null where it shows no new input or was not shown. */
  acknowledge(frameId: number, presentedMs: number | null): void;
  undecodable(frame: Frame): void;
}

export class Frames {
  constructor(
    private readonly state_: Pick<ViewerState, 'lastFrame' | 'framesPresented' | 'framesDropped'>,
    private readonly meter_: StreamMeter,
    private readonly hooks_: FrameHooks,
  ) {}

  /** `hidden`: the frame shows another scene than the one that is looked at. */
  arrived(frame: Frame, hidden: boolean): void {
    if (hidden) this.dropped(frame, 'newer');
    else this.hooks_.show(frame);
  }

  presented({ frame, decodeMs, time }: Presentation): void {
    const latency = this.meter_.presented(frame, decodeMs, time);
    this.hooks_.acknowledge(frame.frameId, latency !== null && latency <= LONGEST_PRESENTED_MS ? latency : null);
    this.state_.lastFrame = frame;
    this.state_.framesPresented += 1;
  }

  dropped(frame: Frame, reason: 'newer' | 'undecodable'): void {
    this.state_.framesDropped += 1;
    this.hooks_.acknowledge(frame.frameId, null);
    if (reason === 'undecodable') this.hooks_.undecodable(frame);
  }
}
