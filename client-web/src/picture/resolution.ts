// Which picture size the page asks for.

import { LARGEST_PIXELS, LARGEST_SIDE, SMALLEST_SIDE } from '../wire/limits.js';

export type ResolutionMode = 'half' | 'capped' | 'full';

export const RESOLUTION_MODES: readonly { readonly mode: ResolutionMode; readonly label: string }[] = [
  { mode: 'half', label: 'Half of the window' },
  { mode: 'capped', label: 'Window, up to 1080p' },
  { mode: 'full', label: 'Every screen pixel' },
];

const CAPPED_PIXELS = 1920 * 1080;

export interface PictureSize {
  readonly width: number;
  readonly height: number;
}

/** What stands beside the choice of a size. `given`: the size that the server has memory for, where that is less. */
export function sizeText(wanted: PictureSize, given: PictureSize | null): string {
  if (given === null) return `${wanted.width} × ${wanted.height} px`;
  const words = `${given.width} × ${given.height} of ${wanted.width} × ${wanted.height} px`;
  return `given ${words}: the server's memory for pictures is short`;
}

/** The size of a picture, and of the full one where it is smaller. */
export function frameSizeText(frame: PictureSize & { readonly fullWidth: number; readonly fullHeight: number }): string {
  const size = `${frame.width} × ${frame.height}`;
  return frame.width < frame.fullWidth ? `${size} of ${frame.fullWidth} × ${frame.fullHeight} px` : `${size} px`;
}

/**
 * Pixels to ask for, for a window of `width` x `height` CSS pixels. The aspect ratio is kept when the pixel count is
 * limited; both sides stay within what the protocol allows.
 */
export function pictureSize(width: number, height: number, pixelRatio: number, mode: ResolutionMode): PictureSize {
  const ratio = mode === 'half' ? 0.5 : pixelRatio;
  const limit = mode === 'capped' ? CAPPED_PIXELS : LARGEST_PIXELS;
  const wantedWidth = Math.max(1, width * ratio);
  const wantedHeight = Math.max(1, height * ratio);
  const factor = Math.min(1, Math.sqrt(limit / (wantedWidth * wantedHeight)));
  const side = (wanted: number): number =>
    Math.min(LARGEST_SIDE, Math.max(SMALLEST_SIDE, Math.floor(wanted * factor + 1e-6)));
  return { width: side(wantedWidth), height: side(wantedHeight) };
}
