// In words, what keeps pictures from being larger, better or more. Knows no DOM.

import { isVideo, VIDEO_NAMES } from '../wire/frame.js';
import type { Pace } from '../wire/protocol.js';

export interface PaceText {
  readonly label: string; // what limits
  readonly figure: string; // by how much
  readonly help: string;
}

const megabits = (bytesPerSecond: number): string => `${((bytesPerSecond * 8) / 1e6).toFixed(1)} Mbit/s`;

/** Of a picture that came without loss. */
export const exactText = (samples: number): PaceText => ({
  label: 'Exact',
  figure: `${samples} samples`,
  help: 'Every pixel is, bit for bit, that of the picture on the server.',
});

/** The same of one that is denoised, which is no longer what the samples say. */
export const denoisedText = (samples: number): PaceText => ({
  label: 'Denoised',
  figure: `${samples} samples`,
  help: 'The picture came without loss, but the server took its grain away: where samples are few, detail may be missing.',
});

/** Null where nothing limits. */
export function paceText(pace: Pace): PaceText | null {
  const kind = isVideo(pace.codec) ? `are a video (${VIDEO_NAMES[pace.codec]}), have` : 'have';
  const size = `Pictures of a moving view ${kind} ${Math.round(pace.scale * 100)} % of the width and JPEG quality ${pace.quality}`;
  switch (pace.limit) {
    case 'none':
      return null;
    case 'server':
      return {
        label: 'Server',
        figure: `${Math.round(pace.fullMs)} ms a full picture`,
        help: `${size}: the server takes too long for larger ones.`,
      };
    case 'line':
      return {
        label: 'Line',
        figure: `${megabits(pace.bytesPerSecond)}, ${Math.round(pace.roundTripMs)} ms`,
        help: `${size}: they queue for ${Math.round(pace.lineMs)} ms on the way here.`,
      };
    case 'viewer':
      return {
        label: 'This computer',
        figure: `${Math.round(pace.viewerMs)} ms late`,
        help: `${size}: this computer shows them later than it could.`,
      };
  }
}
