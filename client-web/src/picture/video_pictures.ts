// The pictures of a video, each decoded as it comes by the browser's WebCodecs. Each builds on those before: after one that is
// missing none can be decoded until the next key picture. Knows no DOM, so tests bring a decoder of their own.

import type { DecodedImage } from './frame_queue.js';
import { isVideo, VIDEO_NAMES, type Frame, type VideoCodec } from '../wire/frame.js';

/**
 * What is asked of a browser: VP9, profile 0, 8 bits, pictures up to 8192 pixels wide; H.264, constrained baseline, as many
 * pixels as 4096x2304, Annex B. None is to be held back.
 */
export const VIDEO_CONFIGS: Readonly<Record<VideoCodec, VideoDecoderConfig>> = {
  vp9: { codec: 'vp09.00.61.08', optimizeForLatency: true },
  h264: { codec: 'avc1.42e034', optimizeForLatency: true },
};

const MOST_FAILURES = 3; // of pictures in a row, each begun anew
const HELD_MS = 3000; // longer than any decoder works: it waits for the next picture

export interface VideoHooks<Image extends DecodedImage> {
  /** Throws where the browser has none. */
  decoder(init: VideoDecoderInit): Pick<VideoDecoder, 'configure' | 'decode' | 'close' | 'state'>;
  chunk(init: EncodedVideoChunkInit): EncodedVideoChunk;
  /** The picture for the canvas, the upper left of what was decoded, which may be larger and is closed afterwards. */
  image(decoded: VideoFrame, frame: Frame): Promise<Image>;
  /** Videos of that codec cannot be shown: why. */
  failed(codec: VideoCodec, reason: string): void;
}

interface Awaited<Image> {
  readonly frame: Frame;
  readonly resolve: (image: Image | Promise<Image>) => void;
  readonly reject: (error: Error) => void;
  readonly timer: ReturnType<typeof setTimeout>;
}

export class VideoPictures<Image extends DecodedImage> {
  private decoder_: ReturnType<VideoHooks<Image>['decoder']> | null = null;
  private codec_: VideoCodec = 'vp9'; // of the decoder
  private readonly awaited_ = new Map<number, Awaited<Image>>(); // by time stamp
  private time_ = 0;
  private keyNeeded_ = true;
  private failures_ = 0;

  constructor(
    private readonly hooks_: VideoHooks<Image>,
    private readonly heldMs_ = HELD_MS,
  ) {}

  /** Rejects where it cannot be decoded; those that follow cannot either, until a key picture comes. */
  decode(frame: Frame): Promise<Image> {
    if (isVideo(frame.codec) && frame.codec !== this.codec_) this.begin(frame.codec);
    if (this.keyNeeded_ && !frame.key) return Promise.reject(new Error('a picture before it is missing'));
    return new Promise((resolve, reject) => {
      const timestamp = ++this.time_;
      const timer = setTimeout(() => this.held(), this.heldMs_);
      this.awaited_.set(timestamp, { frame, resolve, reject, timer });
      try {
        this.decoder_ ??= this.open();
        this.keyNeeded_ = false;
        this.decoder_.decode(this.hooks_.chunk({ type: frame.key ? 'key' : 'delta', timestamp, data: frame.payload }));
      } catch (error) {
        this.broken(error as Error);
      }
    });
  }

  /** A picture was not given to `decode`. */
  skipped(): void {
    this.keyNeeded_ = true;
  }

  /** To be called when a connection ends: another video begins. */
  reset(): void {
    this.failures_ = 0;
    this.drop(new Error('the connection has ended'));
  }

  /** Another video, of that codec. */
  private begin(codec: VideoCodec): void {
    this.failures_ = 0;
    this.drop(new Error('another video has begun'));
    this.codec_ = codec;
  }

  private open(): NonNullable<typeof this.decoder_> {
    const decoder = this.hooks_.decoder({
      output: (decoded) => this.decoded(decoded),
      error: (error) => {
        if (this.decoder_ === decoder) this.broken(error);
      },
    });
    decoder.configure(VIDEO_CONFIGS[this.codec_]);
    return decoder;
  }

  private decoded(frame: VideoFrame): void {
    const awaited = this.awaited_.get(frame.timestamp);
    if (awaited === undefined) return frame.close();
    this.awaited_.delete(frame.timestamp);
    clearTimeout(awaited.timer);
    this.failures_ = 0;
    awaited.resolve(this.hooks_.image(frame, awaited.frame).finally(() => frame.close()));
  }

  private broken(error: Error): void {
    this.drop(error);
    this.failures_ += 1;
    if (this.failures_ === MOST_FAILURES) this.fail(`fails to decode ${VIDEO_NAMES[this.codec_]} (${error.message})`);
  }

  private held(): void {
    this.drop(new Error('held back'));
    this.fail(`holds pictures of a video (${VIDEO_NAMES[this.codec_]}) back`);
  }

  private fail(what: string): void {
    this.hooks_.failed(this.codec_, `This browser ${what}.`);
  }

  private drop(error: Error): void {
    const decoder = this.decoder_;
    this.decoder_ = null;
    this.keyNeeded_ = true;
    if (decoder !== null && decoder.state !== 'closed') decoder.close();
    for (const { reject, timer } of this.awaited_.values()) {
      clearTimeout(timer);
      reject(error);
    }
    this.awaited_.clear();
  }
}
