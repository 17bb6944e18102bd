// What was picked, in words. Knows no DOM.

import { length, type Vec3 } from '../../camera/vector.js';
import type { PickedSurface } from '../../wire/picked_message.js';

export const titleOf = ({ object, material }: Pick<PickedSurface, 'object' | 'material'>): string =>
  object || material || 'A surface';

/** Three significant digits, in a unit that fits. */
export function lengthText(metres: number): string {
  const size = Math.abs(metres);
  const [factor, unit] = size >= 1000 ? [1e-3, 'km'] : size >= 1 || size === 0 ? [1, 'm'] : size >= 0.01 ? [100, 'cm'] : [1000, 'mm'];
  return `${Number((metres * factor).toPrecision(3))} ${unit}`;
}

const AXES: readonly (readonly [string, Vec3])[] = [
  ['right (+x)', [1, 0, 0]],
  ['left (−x)', [-1, 0, 0]],
  ['up (+y)', [0, 1, 0]],
  ['down (−y)', [0, -1, 0]],
  ['front (+z)', [0, 0, 1]],
  ['back (−z)', [0, 0, -1]],
];

/** An axis of the world where it lies along one, within half a degree; else its components. */
export function normalText(normal: Vec3): string {
  if (!(length(normal) > 0.5)) return 'none';
  const along = AXES.find(([, axis]) => axis.reduce((sum, value, i) => sum + value * normal[i]!, 0) > 0.99996);
  return along?.[0] ?? normal.map((value) => value.toFixed(2).replace('-', '−')).join(', ');
}
