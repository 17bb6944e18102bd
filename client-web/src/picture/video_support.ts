// Which videos this page shows, and why not; the server is told, and sends JPEG instead.

import { isVideo, VIDEO_CODECS, VIDEO_NAMES, type VideoCodec } from '../wire/frame.js';
import { VIDEO_CONFIGS } from './video_pictures.js';

export interface SupportHooks {
  /** `shown` has changed. */
  changed(): void;
  notice(text: string): void;
}

/** By codec: why it cannot be shown, or null. */
export type VideoFaults = Record<VideoCodec, string | null>;

const faultsOf = (fault: (codec: VideoCodec) => string | null): VideoFaults => ({
  vp9: fault('vp9'),
  h264: fault('h264'),
});

/** Why the browser cannot decode each. */
export async function videoFaults(
  decoder: Pick<typeof VideoDecoder, 'isConfigSupported'> | undefined,
  secure: boolean,
): Promise<VideoFaults> {
  if (decoder === undefined) {
    const fault = secure
      ? 'This browser cannot decode video.'
      : 'Browsers decode video only on pages that come by https or from this computer.';
    return faultsOf(() => fault);
  }
  const found = await Promise.all(
    VIDEO_CODECS.map((codec) => decoder.isConfigSupported(VIDEO_CONFIGS[codec]).catch(() => null)),
  );
  return faultsOf((codec) =>
    found[VIDEO_CODECS.indexOf(codec)]?.supported === true ? null : `This browser cannot decode ${VIDEO_NAMES[codec]}.`,
  );
}

export class VideoSupport {
  private faults_ = faultsOf(() => 'It is not known yet whether this browser decodes video.');
  private made_: readonly string[] = VIDEO_CODECS;
  private wanted_: VideoCodec | null = null;

  constructor(
    private readonly hooks_: SupportHooks,
    found: Promise<VideoFaults>,
  ) {
    void found.then((faults) => {
      this.faults_ = faults;
      this.hooks_.changed();
      this.tell();
    });
  }

  /** For the server. */
  get shown(): Record<VideoCodec, boolean> {
    return { vp9: this.faults_.vp9 === null, h264: this.faults_.h264 === null };
  }

  /** What the server can make, as its `hello` says. */
  served(videos: readonly string[]): void {
    this.made_ = videos;
  }

  /** What the setting `codec` says now. */
  asked(codec: unknown): void {
    const wanted = isVideo(codec) ? codec : null;
    if (wanted === this.wanted_) return;
    this.wanted_ = wanted;
    this.tell();
  }

  /** It turned out not to work. Where another video takes its place nobody needs to know. */
  failed(codec: VideoCodec, reason: string): void {
    if (this.faults_[codec] !== null) return;
    this.faults_[codec] = reason;
    this.hooks_.changed();
    const others = VIDEO_CODECS.some((other) => this.faultOf(other) === null);
    if (this.wanted_ === codec || !others) this.hooks_.notice(`${reason} Pictures come as JPEG.`);
  }

  /** Why it does not come, or null. */
  private faultOf(codec: VideoCodec): string | null {
    return this.made_.includes(codec) ? this.faults_[codec] : `This server is built without ${VIDEO_NAMES[codec]}.`;
  }

  /** To who asked for a video that does not come. */
  private tell(): void {
    const codec = this.wanted_;
    if (codec === null) return;
    const fault = this.faultOf(codec);
    if (fault !== null) this.hooks_.notice(`${fault} Pictures come as JPEG.`);
  }
}
