// What effects cost, as docs/reference/protocol.md tells it.

import { listOf, fieldsOf, numberOf, textOf, type Fields } from './fields.js';
import { ProtocolError } from './frame.js';

/** What an effect costs, measured with and without it. */
export interface EffectCost {
  readonly name: string;
  readonly onMs: number;
  readonly offMs: number;
  readonly lowMs: number; // least and most that it cost in one pair of frames
  readonly highMs: number;
  readonly raysOn: number;
  readonly raysOff: number;
}

export interface EffectCosts {
  readonly type: 'effectCosts';
  readonly state: 'ready';
  readonly scene: string;
  readonly device: string;
  readonly width: number; // pixels of the picture it was measured with
  readonly height: number;
  readonly scale: number; // pixels of the view over those
  readonly rows: readonly EffectCost[];
}

export type EffectCostsMessage =
  | EffectCosts
  | { readonly type: 'effectCosts'; readonly state: 'measuring'; readonly share: number }
  | { readonly type: 'effectCosts'; readonly state: 'failed'; readonly what: string };

export function effectCostsOf(fields: Fields): EffectCostsMessage {
  const state = fields['state'];
  if (state === 'measuring') return { type: 'effectCosts', state, share: numberOf(fields['share']) };
  if (state === 'failed') return { type: 'effectCosts', state, what: textOf(fields['what']) };
  if (state !== 'ready') {
    throw new ProtocolError(`effectCosts.state: ${String(state)}, allowed: measuring, ready, failed`);
  }
  return {
    type: 'effectCosts',
    state,
    scene: textOf(fields['scene']),
    device: textOf(fields['device']),
    width: numberOf(fields['width']),
    height: numberOf(fields['height']),
    scale: Math.max(numberOf(fields['scale'], 1), 1),
    rows: listOf(fields['rows']).map((entry) => {
      const row = fieldsOf(entry);
      return {
        name: textOf(row['name']),
        onMs: numberOf(row['onMs']),
        offMs: numberOf(row['offMs']),
        lowMs: numberOf(row['lowMs']),
        highMs: numberOf(row['highMs']),
        raysOn: numberOf(row['raysOn']),
        raysOff: numberOf(row['raysOff']),
      };
    }),
  };
}
