// What the page may say to the server (docs/reference/protocol.md).

import type { Camera } from '../camera/camera.js';
import type { VideoCodec } from './frame.js';
import type { SettingValues } from './protocol.js';

export type PictureFormat = 'png' | 'exr' | 'jpg';

export type ViewerMessage =
  | ({ type: 'camera'; inputId: number; moving: boolean } & Camera)
  | { type: 'settings'; inputId: number; values: SettingValues }
  | { type: 'resolution'; inputId: number; width: number; height: number }
  | { type: 'scene'; name: string }
  | { type: 'ack'; frameId: number; presentedMs: number | null; shownMs: number | null; undecodable: boolean }
  | { type: 'picture'; format: PictureFormat }
  | { type: 'path'; playing: boolean }
  | { type: 'effectCosts' }
  | { type: 'accuracy'; seconds: number } // to measure the view for; 0: gives that up
  | { type: 'pick'; id: number; x: number; y: number } // 0..1 of the picture, from its top left corner
  | { type: 'watch'; inputId: number; view?: string; key?: string } // without a view: one of its own
  | { type: 'drive'; inputId: number; viewer?: number; refuse?: boolean } // without a viewer: asks to drive
  | { type: 'ping'; time: number; roundTripMs: number | null } // of the ping before
  | ({ type: 'client'; visible: boolean; exact: boolean } & Record<VideoCodec, boolean>) // seen; puts parts together; decodes
  | { type: 'token'; token: string };
