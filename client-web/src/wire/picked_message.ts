// What is under a place of the picture, as docs/reference/protocol.md tells it.

import type { Vec3 } from '../camera/vector.js';
import { vectorOf } from './camera_fields.js';
import { numberOf, textOf, type Fields } from './fields.js';

export interface PickedSurface {
  readonly object: string; // '': it has no name
  readonly material: string;
  readonly distance: number; // metres from the camera
  readonly depth: number; // metres along the camera's forward
  readonly position: Vec3;
  readonly normal: Vec3; // unit, towards the camera; 0 for a triangle without area
}

export interface PickedMessage {
  readonly type: 'picked';
  readonly id: number; // of the question
  readonly surface: PickedSurface | null; // nothing is there
}

/** Throws ProtocolError. */
export function pickedOf(fields: Fields): PickedMessage {
  const id = numberOf(fields['id']);
  if (fields['found'] !== true) return { type: 'picked', id, surface: null };
  return {
    type: 'picked',
    id,
    surface: {
      object: textOf(fields['object']),
      material: textOf(fields['material']),
      distance: numberOf(fields['distance']),
      depth: numberOf(fields['depth']),
      position: vectorOf(fields['position'], 'picked.position'),
      normal: vectorOf(fields['normal'], 'picked.normal'),
    },
  };
}
