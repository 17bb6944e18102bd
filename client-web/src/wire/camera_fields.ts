// Reads places and cameras out of messages of the server.

import type { Camera } from '../camera/camera.js';
import type { Vec3 } from '../camera/vector.js';
import { fieldsOf, listOf, numberOf } from './fields.js';
import { ProtocolError } from './frame.js';

/** Throws ProtocolError that names the field, `where`. */
export function vectorOf(value: unknown, where: string): Vec3 {
  const [x, y, z] = listOf(value);
  if (typeof x !== 'number' || typeof y !== 'number' || typeof z !== 'number') {
    throw new ProtocolError(`${where}: ${JSON.stringify(value)}, allowed: three numbers`);
  }
  return [x, y, z];
}

/** As vectorOf. */
export function cameraOf(value: unknown, where: string): Camera {
  const fields = fieldsOf(value);
  return {
    position: vectorOf(fields['position'], `${where}.position`),
    forward: vectorOf(fields['forward'], `${where}.forward`),
    up: vectorOf(fields['up'], `${where}.up`),
    fieldOfView: numberOf(fields['fieldOfView'], 60),
  };
}
