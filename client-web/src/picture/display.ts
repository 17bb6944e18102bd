// Shows frames on the canvas: decoded off the main thread by createImageBitmap, handed to the canvas without a copy, at
// most one per animation frame.

import { ExactPicture } from './exact_picture.js';
import { FrameQueue } from './frame_queue.js';
import { VideoPictures } from './video_pictures.js';
import { isVideo, MIME_TYPES, type Frame, type VideoCodec } from '../wire/frame.js';

export interface Presentation {
  readonly frame: Frame;
  readonly decodeMs: number;
  readonly time: number; // performance.now() when the browser had taken the picture for its next refresh
}

export interface DisplayHooks {
  /** In the animation frame that puts the picture on the canvas. */
  drawn(frame: Frame): void;
  presented(presentation: Presentation): void;
  dropped(frame: Frame, reason: 'newer' | 'undecodable'): void;
  /** A part of a picture was taken, or is of no use. */
  partTaken(frame: Frame): void;
  /** Videos cannot be shown: why. */
  videoFailed(codec: VideoCodec, reason: string): void;
}

/** The bytes of the file are the pixels: no profile of the screen, no alpha. */
const decodeStill = (frame: Frame): Promise<ImageBitmap> =>
  createImageBitmap(new Blob([frame.payload], { type: MIME_TYPES[frame.codec] }), {
    colorSpaceConversion: 'none',
    premultiplyAlpha: 'none',
  });

/** One picture of parts. */
function putTogether(parts: readonly { readonly image: ImageBitmap; readonly frame: Frame }[], whole: Frame): ImageBitmap {
  const canvas = new OffscreenCanvas(whole.width, whole.height);
  const context = canvas.getContext('2d', { alpha: false });
  if (context === null) throw new DisplayError('This browser cannot put pictures together.');
  for (const { image, frame } of parts) context.drawImage(image, frame.place?.x ?? 0, frame.place?.y ?? 0);
  return canvas.transferToImageBitmap();
}

/** The canvas cannot show pictures in this browser. */
export class DisplayError extends Error {}

export class Display {
  private readonly context_: ImageBitmapRenderingContext;
  private readonly queue_: FrameQueue<ImageBitmap>;
  private readonly exact_: ExactPicture<ImageBitmap>;
  private readonly video_: VideoPictures<ImageBitmap>;
  private readonly afterPaint_ = new MessageChannel();
  private shown_: Omit<Presentation, 'time'>[] = [];

  constructor(
    private readonly canvas_: HTMLCanvasElement,
    hooks: DisplayHooks,
  ) {
    const context = canvas_.getContext('bitmaprenderer', { alpha: false });
    if (context === null) throw new DisplayError('This browser cannot draw decoded pictures on a canvas.');
    this.context_ = context;
    this.video_ = new VideoPictures<ImageBitmap>({
      decoder: (init) => new VideoDecoder(init),
      chunk: (init) => new EncodedVideoChunk(init),
      image: (decoded, { width, height }) =>
        decoded.displayWidth === width && decoded.displayHeight === height
          ? createImageBitmap(decoded)
          : createImageBitmap(decoded, 0, 0, width, height),
      failed: hooks.videoFailed,
    });
    this.queue_ = new FrameQueue<ImageBitmap>({
      decode: (frame) => (isVideo(frame.codec) ? this.video_.decode(frame) : decodeStill(frame)),
      schedule: () => this.schedule(),
      draw: (image, frame, decodeMs) => {
        this.draw(image, frame, decodeMs);
        hooks.drawn(frame);
      },
      dropped: hooks.dropped,
      now: () => performance.now(),
    });
    this.exact_ = new ExactPicture<ImageBitmap>({
      decode: decodeStill,
      complete: (parts, frame) =>
        this.queue_.pushDecoded({ ...frame, kind: 'frame', exact: true }, putTogether(parts, frame)),
      acknowledge: hooks.partTaken,
    });
    document.addEventListener('visibilitychange', () => {
      if (document.hidden) this.queue_.present();
    });
    // A message posted from an animation frame arrives after the page has been laid out and painted.
    this.afterPaint_.port1.onmessage = () => {
      const time = performance.now();
      const shown = this.shown_;
      this.shown_ = [];
      for (const presentation of shown) hooks.presented({ ...presentation, time });
    };
  }

  /**
   * A hidden page gets no animation frames; a timer, which browsers then slow down to about 1/s, keeps it
   * acknowledging.
   */
  private schedule(): void {
    if (document.hidden) window.setTimeout(() => this.queue_.present(), 0);
    else requestAnimationFrame(() => this.queue_.present());
  }

  push(frame: Frame): void {
    if (frame.kind === 'part') return void this.exact_.push(frame);
    this.exact_.forget();
    void this.queue_.push(frame);
  }

  /** A picture of a video was not pushed. */
  skipped(): void {
    this.video_.skipped();
  }

  /** To be called when a connection ends: frame ids begin anew with the next one. */
  reset(): void {
    this.queue_.reset();
    this.exact_.forget();
    this.video_.reset();
    this.shown_ = [];
  }

  private draw(image: ImageBitmap, frame: Frame, decodeMs: number): void {
    // The canvas keeps its own size and would squeeze the picture into it.
    if (this.canvas_.width !== image.width || this.canvas_.height !== image.height) {
      this.canvas_.width = image.width;
      this.canvas_.height = image.height;
    }
    this.context_.transferFromImageBitmap(image);
    this.shown_.push({ frame, decodeMs });
    this.afterPaint_.port2.postMessage(null);
  }
}
