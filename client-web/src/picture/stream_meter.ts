// What is measured of the stream of pictures: rates, delays, and the newest frames with their times. Knows no DOM.

import type { Frame } from '../wire/frame.js';
import { FrameTrace } from './frame_trace.js';
import { MotionToPhoton, RateMeter, Window } from './latency.js';
import { TimeLeft } from './time_left.js';

const PAUSE = 1000; // ms
const STAGES_KEPT = 30; // frames

export class StreamMeter {
  readonly motionToPhoton = new MotionToPhoton(240);
  readonly frameIntervals = new Window(120); // ms between presented frames
  readonly decodeMs = new Window(STAGES_KEPT);
  readonly roundTrips = new Window(5); // ms
  readonly presentedRate = new RateMeter(1000);
  readonly receivedRate = new RateMeter(2000); // bytes
  readonly trace = new FrameTrace();
  readonly timeLeft = new TimeLeft();
  readonly recentFrames: Frame[] = []; // newest last, at most STAGES_KEPT
  private interval_ = 0; // ms between the newest two frames
  lastPresentedAt = -Infinity; // ms, the clock of `presented`

  /** A camera is sent at `time`; `eventTime`: of the motion that made it, null where it came by none. */
  sent(inputId: number, eventTime: number | null, time: number): void {
    if (eventTime !== null) this.motionToPhoton.sent(inputId, eventTime);
    this.trace.sent(inputId, eventTime ?? time, time);
  }

  /**
   * Frames shown per second at `now`, below one where they come seldom; null where none has come for long. A pause of
   * `restMs` is a rest.
   */
  shownRate(now: number, restMs: number): number | null {
    const pause = now - this.lastPresentedAt;
    if (pause > restMs) return null;
    const frames = this.presentedRate.events(now);
    return frames > 1 ? frames : 1000 / Math.max(pause, this.interval_, 1000);
  }

  /**
   * A frame that came at `arrived` is on the screen since `time`; answers its motion to photon, or null where it shows no new
   * input.
   */
  presented(frame: Frame, decodeMs: number, time: number, arrived: number): number | null {
    const oneWay = (this.roundTrips.quantile(0) ?? 0) / 2;
    this.trace.presented(frame, { oneWay, arrived, decoded: Math.min(arrived + decodeMs, time), presented: time });
    this.decodeMs.push(decodeMs);
    this.recentFrames.push(frame);
    if (this.recentFrames.length > STAGES_KEPT) this.recentFrames.shift();
    this.presentedRate.push(time, 1);
    this.timeLeft.shown(frame.samples, time);
    // A pause between inputs is no slow frame.
    this.interval_ = Number.isFinite(this.lastPresentedAt) ? time - this.lastPresentedAt : 0;
    if (time - this.lastPresentedAt < PAUSE) this.frameIntervals.push(time - this.lastPresentedAt);
    this.lastPresentedAt = time;
    return this.motionToPhoton.presented(frame.inputId, time);
  }
}
