// Puts the parts of a picture together, which come without loss when the view rests. Knows no DOM.

import type { Frame } from '../wire/frame.js';
import type { DecodedImage } from './frame_queue.js';

export interface ExactHooks<Image extends DecodedImage> {
  decode(frame: Frame): Promise<Image>;
  /** All parts of a picture are there, each with its place; `frame`: the last of them, which is not acknowledged yet. */
  complete(parts: readonly { readonly image: Image; readonly frame: Frame }[], frame: Frame): void;
  /** It was decoded and waits for the others, or cannot be used. */
  acknowledge(frame: Frame): void;
}

export class ExactPicture<Image extends DecodedImage> {
  private parts_: { image: Image; frame: Frame }[] = [];
  private epoch_ = 0;

  constructor(private readonly hooks_: ExactHooks<Image>) {}

  /** Another picture has come: what was put together so far is of no use. */
  forget(): void {
    this.epoch_ += 1;
    for (const { image } of this.parts_) image.close();
    this.parts_ = [];
  }

  /** Resolves when it is decoded, for tests. */
  async push(frame: Frame): Promise<void> {
    const epoch = this.epoch_;
    let image: Image;
    try {
      image = await this.hooks_.decode(frame);
    } catch {
      this.hooks_.acknowledge(frame);
      return;
    }
    if (epoch !== this.epoch_) {
      image.close();
      this.hooks_.acknowledge(frame);
      return;
    }
    this.parts_.push({ image, frame });
    const pixels = this.parts_.reduce((sum, { frame: { place } }) => sum + (place?.width ?? 0) * (place?.height ?? 0), 0);
    if (pixels < frame.width * frame.height) {
      this.hooks_.acknowledge(frame);
      return;
    }
    const parts = this.parts_;
    this.parts_ = [];
    this.hooks_.complete(parts, frame);
    for (const part of parts) part.image.close();
  }
}
