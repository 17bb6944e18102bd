// What the accuracy panel says of each row that was measured, in which order they stand, what to set to get one, and what
// of the view has changed since. Knows no DOM.

import type { Camera } from '../../camera/camera.js';
import { duration, percent } from '../../page/format.js';
import type { Accuracy, AccuracyRow } from '../../wire/accuracy_message.js';
import type { SettingRow, SettingValue, SettingValues } from '../../wire/protocol.js';
import { sameValue } from '../settings/settings_model.js';
import type { Measured, ViewThen } from './accuracy_model.js';

type Schema = readonly SettingRow[];
type ValueOf = (name: string) => SettingValue | undefined;

const COMBINATION = 'combination';
const MOST_CHANGES = 4; // that are named

export interface RowGroup {
  readonly title: string;
  readonly rows: readonly AccuracyRow[];
}

/** A frame's time, in seconds from one on. */
export const frameTime = (ms: number): string => (ms >= 999.5 ? `${(ms / 1000).toPrecision(3)} s` : duration(ms));

/** A difference of two times, in two digits: "+41 ms". */
export function moreTime(ms: number): string {
  const [size, unit] = Math.abs(ms) >= 995 ? [Math.abs(ms) / 1000, 's'] : [Math.abs(ms), 'ms'];
  const shown = size >= 100 ? Math.round(size) : Number(size.toPrecision(2));
  return `${ms < 0 ? '\u2212' : '+'}${shown} ${unit}`;
}

export const labelOf = (name: string, schema: Schema): string => schema.find((row) => row.name === name)?.label ?? name;

/** "aoSamples=4 renderScale=0.5" as "AO samples 4, Render scale 0.5"; what else stands there stays. */
export const settingWords = (text: string, schema: Schema): string =>
  text
    .replace(/ (?=[A-Za-z]\w*=)/g, ', ')
    .replace(/([A-Za-z]\w*)=([^\s,]+)/g, (_, name: string, value: string) => `${labelOf(name, schema)} ${value}`);

export function rowName(row: AccuracyRow, schema: Schema): string {
  if (row.given) return 'As it was';
  return row.knob === COMBINATION ? settingWords(row.value, schema) : `${labelOf(row.knob, schema)} ${row.value}`;
}

/** The settings as they were, of which every setting that was turned has a row. */
export function givenRow({ rows }: Accuracy): AccuracyRow | null {
  const given = rows.filter((row) => row.given && !row.coding && !row.byLight);
  // Where fewer samples were measured than the view has, the row of the samples would set these.
  return given.find(({ set }) => Object.keys(set).length === 0) ?? given[0] ?? null;
}

/** A row in a sentence: what is turned, and what that does to error and time. */
export function rowWords(row: AccuracyRow, { accuracy, then }: Measured, schema: Schema): string {
  const { scale } = accuracy;
  const given = givenRow(accuracy);
  const name = turnWords(row, accuracy, then, schema);
  if (row.coding) {
    return `${name}: coding takes ${frameTime(scale * row.ms)}, FLIP ${row.flip.toFixed(3)}, PSNR ${row.psnrDb.toFixed(1)} dB`;
  }
  const error = row.rmse === null ? '' : percent(row.rmse);
  if (row.given || given === null) return `${name}: ${error === '' ? '' : `error ${error}, `}${frameTime(scale * row.ms)}`;
  const before = row.byLight || given.rmse === null ? error : percent(given.rmse);
  const errors = row.byLight ? `${error} against all light` : before === error ? `${error} as before` : `${before} to ${error}`;
  const alike = row.low <= given.high && given.low <= row.high;
  const time = alike ? 'as fast' : moreTime(scale * (row.ms - given.ms));
  return `${name}: ${error === '' ? '' : `error ${errors}, `}${time}`;
}

/** "AO samples from 9 to 25". */
function turnWords(row: AccuracyRow, accuracy: Accuracy, then: ViewThen, schema: Schema): string {
  if (row.given || row.knob === COMBINATION) return rowName(row, schema);
  const was = accuracy.rows.find(({ knob, given }) => given && knob === row.knob)?.value ?? valueText(then.values[row.knob]);
  return was === '' ? rowName(row, schema) : `${labelOf(row.knob, schema)} from ${was} to ${row.value}`;
}

const valueText = (value: SettingValue | undefined): string =>
  value === undefined ? '' : typeof value === 'boolean' ? (value ? 'on' : 'off') : String(value);

const byTime = (a: AccuracyRow, b: AccuracyRow): number => a.ms - b.ms;

/** As it was, and what is best for its time; the fastest first. */
export function bestRows(accuracy: Accuracy): readonly AccuracyRow[] {
  const given = givenRow(accuracy);
  const best = accuracy.rows.filter((row) => row.front && !row.given);
  return [...(given === null ? [] : [given]), ...best].sort(byTime);
}

/** What is not among the best, by setting in the server's order; combinations last. */
export function otherRows(accuracy: Accuracy, schema: Schema): readonly RowGroup[] {
  const others = accuracy.rows.filter((row) => !row.front && !row.given);
  const knobs = [...new Set(others.map(({ knob }) => knob))].sort((a, b) => Number(a === COMBINATION) - Number(b === COMBINATION));
  return knobs.map((knob) => {
    const rows = others.filter((row) => row.knob === knob);
    const was = accuracy.rows.find((row) => row.given && row.knob === knob)?.value;
    const remarks = [
      was === undefined ? '' : `${was} as it was`,
      rows.every((row) => row.coding) ? 'coding alone' : '',
      rows.some((row) => row.byLight) ? 'against all light' : '',
    ].filter((remark) => remark !== '');
    const title = knob === COMBINATION ? 'Combinations' : labelOf(knob, schema);
    return { title: remarks.length === 0 ? title : `${title} (${remarks.join(', ')})`, rows };
  });
}

/** The rows that one plot can hold: their errors are against the same reference. */
export function plottedRows(accuracy: Accuracy): readonly AccuracyRow[] {
  const given = givenRow(accuracy);
  return accuracy.rows.filter((row) => row.rmse !== null && !row.coding && !row.byLight && (!row.given || row === given));
}

/** The names of all settings that were turned. */
const turned = (accuracy: Accuracy): ReadonlySet<string> => new Set(accuracy.rows.flatMap(({ set }) => Object.keys(set)));

/** What leads to a row from the settings as they are now: its own values, and those of what another row has turned. */
export function valuesFor(row: AccuracyRow, { accuracy, then }: Measured, value: ValueOf): SettingValues {
  const values: Record<string, SettingValue> = { ...row.set };
  for (const name of turned(accuracy)) {
    const was = then.values[name];
    if (!(name in row.set) && was !== undefined && !sameValue(value(name), was)) values[name] = was;
  }
  return values;
}

/** The row whose settings are those of now, or null. */
export function rowNow({ accuracy, then }: Measured, value: ValueOf): AccuracyRow | null {
  const names = [...turned(accuracy)];
  const fits = ({ set }: AccuracyRow): boolean =>
    names.every((name) => {
      const wanted = set[name] ?? then.values[name];
      return wanted === undefined || sameValue(value(name), wanted);
    });
  const given = givenRow(accuracy);
  return (given !== null && fits(given) ? given : accuracy.rows.find(fits)) ?? null;
}

function sameCamera(a: Camera, b: Camera): boolean {
  const numbers = (camera: Camera): readonly number[] =>
    [...camera.position, ...camera.forward, ...camera.up, camera.fieldOfView];
  const others = numbers(b);
  return numbers(a).every((number, i) => Math.abs(number - others[i]!) <= 1e-6 * Math.max(1, Math.abs(number)));
}

/** What of the view is not as it was when it was measured, beside the row that is chosen; '': nothing. */
export function changeWords(measured: Measured, now: ViewThen, schema: Schema): string {
  const { then, accuracy } = measured;
  const chosen = rowNow(measured, (name) => now.values[name]) === null ? new Set<string>() : turned(accuracy);
  const changed = schema
    .filter(({ name, acts }) => acts === 'film' && name !== 'showPartition' && !chosen.has(name))
    .filter(({ name }) => then.values[name] !== undefined && !sameValue(now.values[name], then.values[name]))
    .map(({ label }) => label);
  if (now.size.width !== then.size.width || now.size.height !== then.size.height) changed.unshift('picture size');
  if (!sameCamera(then.camera, now.camera)) changed.unshift('camera');
  if (changed.length === 0) return '';
  const more = changed.length - MOST_CHANGES;
  const named = changed.slice(0, MOST_CHANGES).join(', ') + (more > 0 ? ` and ${more} more` : '');
  return `Changed since: ${named}. The figures are of the view before.`;
}

/** What was measured, where, and how far it can be trusted. */
export function factWords({ accuracy, then }: Measured): string {
  const { device, width, height, seconds, scale, samples, referenceError, modelError } = accuracy;
  const own = then.values['samples'];
  const parts = [`Measured on ${device} at ${width} × ${height} pixels in ${frameTime(1000 * seconds)}.`];
  if (samples !== null && typeof own === 'number' && samples !== own) {
    parts.push(`Pictures had ${samples} samples a pixel, of the view's ${own}.`);
  }
  if (scale > 1.05) parts.push(`Times are told for this view, of ${Number(scale.toPrecision(2))} times as many pixels.`);
  if (referenceError !== null) parts.push(`The reference itself is known to ${percent(referenceError)}.`);
  if (modelError !== null) parts.push(`Without any limit this view is ${percent(modelError)} from all light.`);
  return parts.join(' ');
}
