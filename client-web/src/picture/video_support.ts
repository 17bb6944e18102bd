// Whether this page shows videos, and why not; the server is told, and sends JPEG instead.

import { VIDEO_CONFIG } from './video_pictures.js';

export interface SupportHooks {
  /** `works` has changed. */
  changed(): void;
  notice(text: string): void;
}

/** Why the browser cannot decode the video, or null. */
export async function videoFault(
  decoder: Pick<typeof VideoDecoder, 'isConfigSupported'> | undefined,
  secure: boolean,
): Promise<string | null> {
  if (decoder === undefined) {
    return secure
      ? 'This browser cannot decode video.'
      : 'Browsers decode video only on pages that come by https or from this computer.';
  }
  const supported = await decoder.isConfigSupported(VIDEO_CONFIG).catch(() => null);
  return supported?.supported === true ? null : 'This browser cannot decode VP9.';
}

export class VideoSupport {
  private fault_: string | null = 'It is not known yet whether this browser decodes video.';
  private wanted_ = false;

  constructor(
    private readonly hooks_: SupportHooks,
    found: Promise<string | null>,
  ) {
    void found.then((fault) => {
      this.fault_ = fault;
      this.hooks_.changed();
      if (this.wanted_) this.tell();
    });
  }

  get works(): boolean {
    return this.fault_ === null;
  }

  /** What the setting `codec` says now. */
  asked(codec: unknown): void {
    const wanted = codec === 'vp9';
    if (wanted && !this.wanted_) this.tell();
    this.wanted_ = wanted;
  }

  /** It turned out not to work. */
  failed(reason: string): void {
    if (!this.works) return;
    this.fault_ = reason;
    this.hooks_.changed();
    this.tell();
  }

  private tell(): void {
    if (this.fault_ !== null) this.hooks_.notice(`${this.fault_} Pictures come as JPEG.`);
  }
}
