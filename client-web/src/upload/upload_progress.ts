// How an upload goes, in words. Knows no DOM.

import { bytes, percent } from '../page/format.js';
import { waitText } from '../picture/time_left.js';

const SHORTEST_LOOK = 2000; // ms before the line's rate says anything of the rest

export interface Sent {
  readonly loaded: number; // bytes
  readonly total: number;
  readonly ms: number; // since the first one
}

const shareOf = ({ loaded, total }: Sent): number => (total > 0 ? loaded / total : 0);

/** "Uploading boat.glb: 43 %, 8.6 MB of 20 MB, 12 s left"; what is not known yet is left out. */
export function progressText(scene: string, sent: Sent): string {
  const parts = [percent(shareOf(sent)), `${bytes(sent.loaded)} of ${bytes(sent.total)}`];
  if (sent.total > 0 && sent.loaded >= sent.total) parts.splice(0, 2, 'all is sent, the server reads it');
  else if (sent.ms >= SHORTEST_LOOK && sent.loaded > 0)
    parts.push(`${waitText(((sent.total - sent.loaded) * sent.ms) / sent.loaded)} left`);
  return `Uploading ${scene}: ${parts.join(', ')}`;
}

/** Of one that the line did not bring to its end. */
export const brokenText = (scene: string, sent: Sent): string =>
  `The line broke after ${percent(shareOf(sent))} of ${scene}. The server keeps nothing of it: send it again from the beginning?`;
