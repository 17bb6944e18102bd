// What settings cost and how far from exact their pictures are, as docs/reference/protocol.md tells it.

import { fieldsOf, listOf, numberOf, settingValuesOf, textOf, type Fields } from './fields.js';
import { ProtocolError } from './frame.js';
import type { SettingValues } from './protocol.js';

/** One setting turned by itself, or several at once, as measured. */
export interface AccuracyRow {
  readonly knob: string; // the name of the setting, or "combination"
  readonly value: string; // in words, as "25" or "aoSamples=4 renderScale=0.5"
  readonly set: SettingValues; // leads here from the settings as they were
  readonly given: boolean; // the settings as they were
  readonly exact: boolean; // the most exact ones of this view
  readonly byLight: boolean; // the error is against all light
  readonly coding: boolean; // time and difference are those of coding
  readonly ms: number; // median of a frame's time, at the size that was measured
  readonly low: number; // quartiles, ms
  readonly high: number;
  readonly rmse: number | null; // relative, against the view's most exact settings; null: not known
  readonly bias: number; // mean of the difference, relative
  readonly flip: number; // 0..1
  readonly psnrDb: number;
  readonly front: boolean; // nothing that was measured is both faster and nearer
}

export interface Accuracy {
  readonly type: 'accuracy';
  readonly state: 'ready';
  readonly scene: string;
  readonly device: string;
  readonly width: number; // pixels that were measured
  readonly height: number;
  readonly scale: number; // pixels of the view over those
  readonly samples: number | null; // of a pixel, with the settings as they were; null: not told
  readonly seconds: number; // that it took
  readonly referenceError: number | null; // relative RMSE of the reference itself
  readonly modelError: number | null; // of the most exact settings against all light
  readonly rows: readonly AccuracyRow[];
  readonly pictures: { readonly exact: string; readonly given: string } | null; // PNG files, base64
}

export type AccuracyMessage =
  | Accuracy
  | { readonly type: 'accuracy'; readonly state: 'measuring'; readonly share: number; readonly what: string }
  | { readonly type: 'accuracy'; readonly state: 'given-up' }
  | { readonly type: 'accuracy'; readonly state: 'failed'; readonly what: string };

const BASE64 = /^[A-Za-z0-9+/]+={0,2}$/;

export function accuracyOf(fields: Fields): AccuracyMessage {
  const type = 'accuracy';
  const state = fields['state'];
  if (state === 'measuring') {
    const share = Math.min(1, Math.max(0, numberOf(fields['share'])));
    return { type, state, share, what: textOf(fields['what']) };
  }
  if (state === 'given-up') return { type, state };
  if (state === 'failed') return { type, state, what: textOf(fields['what']) };
  if (state === 'ready') return readyOf(fields);
  throw new ProtocolError(`accuracy.state: ${String(state)}, allowed: measuring, given-up, failed, ready`);
}

function readyOf(fields: Fields): Accuracy {
  const [width, height] = listOf(fields['size']).map((side) => numberOf(side));
  if (!(width! > 0 && height! > 0)) {
    throw new ProtocolError(`accuracy.size: ${JSON.stringify(fields['size'])}, allowed: two numbers above 0`);
  }
  return {
    type: 'accuracy',
    state: 'ready',
    scene: textOf(fields['scene']),
    device: textOf(fields['device']),
    width: width!,
    height: height!,
    scale: Math.max(numberOf(fields['scale'], 1), 1),
    samples: typeof fields['samples'] === 'number' ? fields['samples'] : null,
    seconds: numberOf(fields['seconds']),
    referenceError: errorOf(fields['referenceError'], 'accuracy.referenceError'),
    modelError: errorOf(fields['modelError'], 'accuracy.modelError'),
    rows: listOf(fields['rows']).map((entry, i) => rowOf(fieldsOf(entry), `accuracy.rows[${i}]`)),
    pictures: picturesOf(fields['pictures']),
  };
}

function rowOf(fields: Fields, where: string): AccuracyRow {
  const ms = fields['ms'];
  if (typeof ms !== 'number' || !(ms >= 0)) {
    throw new ProtocolError(`${where}.ms: ${JSON.stringify(ms)}, allowed: 0 and more`);
  }
  return {
    knob: textOf(fields['knob']),
    value: textOf(fields['value']),
    set: settingValuesOf(fields['set']),
    given: fields['given'] === true,
    exact: fields['exact'] === true,
    byLight: fields['byLight'] === true,
    coding: fields['coding'] === true,
    ms,
    low: numberOf(fields['low'], ms),
    high: numberOf(fields['high'], ms),
    rmse: errorOf(fields['rmse'], `${where}.rmse`),
    bias: numberOf(fields['bias']),
    flip: numberOf(fields['flip']),
    psnrDb: numberOf(fields['psnrDb']),
    front: fields['front'] === true,
  };
}

/** 0 and more; null where it is not known. */
function errorOf(value: unknown, where: string): number | null {
  if (value === null || value === undefined) return null;
  if (typeof value === 'number' && value >= 0 && Number.isFinite(value)) return value;
  throw new ProtocolError(`${where}: ${JSON.stringify(value)}, allowed: null, 0 and more`);
}

function picturesOf(value: unknown): Accuracy['pictures'] {
  if (value === null || value === undefined) return null;
  const fields = fieldsOf(value);
  const pictureOf = (name: string): string => {
    const text = textOf(fields[name]);
    if (!BASE64.test(text)) throw new ProtocolError(`accuracy.pictures.${name}: no base64 of a PNG file`);
    return text;
  };
  return { exact: pictureOf('exact'), given: pictureOf('given') };
}
