// Newest wins between decoder and screen: of the frames that are decoded, only the newest waits for the next animation
// frame; older ones are dropped. Knows no DOM, so tests drive it by hand.

import type { Frame } from '../wire/frame.js';

export interface DecodedImage {
  close(): void;
}

export interface FrameQueueHooks<Image extends DecodedImage> {
  decode(frame: Frame): Promise<Image>;
  /** Asks for one call of `present` at the next animation frame. */
  schedule(): void;
  draw(image: Image, frame: Frame, decodeMs: number): void;
  dropped(frame: Frame, reason: 'newer' | 'undecodable'): void;
  now(): number; // milliseconds
}

/** Whether frame id `a` came after `b`; ids wrap at 2^32. */
export const isNewer = (a: number, b: number): boolean => ((a - b) | 0) > 0;

interface Ready<Image> {
  readonly frame: Frame;
  readonly image: Image;
  readonly decodeMs: number;
}

export class FrameQueue<Image extends DecodedImage> {
  private ready_: Ready<Image> | null = null;
  private lastDrawn_: number | null = null;
  private epoch_ = 0;

  constructor(private readonly hooks_: FrameQueueHooks<Image>) {}

  /** Forgets everything of a connection that ended; what it still decodes is thrown away without a word. */
  reset(): void {
    this.epoch_ += 1;
    this.ready_?.image.close();
    this.ready_ = null;
    this.lastDrawn_ = null;
  }

  /** Takes a frame from the wire. Resolves when it is decoded (or given up), for tests. */
  async push(frame: Frame): Promise<void> {
    const epoch = this.epoch_;
    const begin = this.hooks_.now();
    let image: Image;
    try {
      image = await this.hooks_.decode(frame);
    } catch {
      if (epoch === this.epoch_) this.hooks_.dropped(frame, 'undecodable');
      return;
    }
    if (epoch !== this.epoch_) {
      image.close();
      return;
    }
    this.offer({ frame, image, decodeMs: this.hooks_.now() - begin });
  }

  /** Takes a frame that is decoded already. */
  pushDecoded(frame: Frame, image: Image): void {
    this.offer({ frame, image, decodeMs: 0 });
  }

  /** Draws the frame that waits, if any. */
  present(): void {
    const ready = this.ready_;
    if (ready === null) return;
    this.ready_ = null;
    this.lastDrawn_ = ready.frame.frameId;
    this.hooks_.draw(ready.image, ready.frame, ready.decodeMs);
  }

  private offer(next: Ready<Image>): void {
    const waiting = this.ready_;
    const newest = waiting !== null ? waiting.frame.frameId : this.lastDrawn_;
    if (newest !== null && !isNewer(next.frame.frameId, newest)) {
      next.image.close();
      this.hooks_.dropped(next.frame, 'newer');
      return;
    }
    this.ready_ = next;
    if (waiting === null) {
      this.hooks_.schedule();
      return;
    }
    waiting.image.close();
    this.hooks_.dropped(waiting.frame, 'newer');
  }
}
