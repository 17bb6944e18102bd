// The server's word on whose view is looked at.

import type { Camera } from '../camera/camera.js';
import { cameraOf } from './camera_fields.js';
import { isObject, textOf, type Fields } from './fields.js';

export interface WatchingMessage {
  readonly type: 'watching';
  readonly view: string;
  readonly drives: boolean;
  readonly camera: Camera | null; // of the view, for who drives it
}

/** Throws ProtocolError for a camera that is none. */
export function watchingOf(fields: Fields): WatchingMessage {
  return {
    type: 'watching',
    view: textOf(fields['view']),
    drives: fields['drives'] === true,
    camera: isObject(fields['camera']) ? cameraOf(fields['camera'], 'watching.camera') : null,
  };
}
