// A view as the fragment of the page's address: scene, camera, settings that differ from the server's. Knows no DOM.
// #scene=cornell&at=0,1,5&look=0,0,-1&up=0,1,0&fov=60&set.exposure=0.5

import { FIELD_OF_VIEW_HIGH, FIELD_OF_VIEW_LOW, type Camera } from '../camera/camera.js';
import { cross, dot, length, normalize, scale, subtract, type Vec3 } from '../camera/vector.js';
import type { SettingRow, SettingValue, SettingValues } from '../wire/protocol.js';

export interface AddressedView {
  readonly scene: string; // '': the server's own
  readonly camera: Camera | null; // null: the scene's own
  readonly settings: Readonly<Record<string, string>>; // as text, until the server's table says what they are
}

const SETTING = 'set.';
const LONGEST = 8000; // characters; a longer fragment is none of ours
const NO_VIEW: AddressedView = { scene: '', camera: null, settings: {} };

const number = (value: number): string => String(Number(value.toPrecision(7)));
const vector = (value: Vec3): string => value.map(number).join(',');

/** Without the leading #; '': everything is as the server gives it. */
export function fragmentOf({ scene, camera, settings }: AddressedView): string {
  const parts: (readonly [string, string])[] = [];
  if (scene !== '') parts.push(['scene', scene]);
  if (camera !== null) {
    parts.push(['at', vector(camera.position)], ['look', vector(camera.forward)], ['up', vector(camera.up)]);
    parts.push(['fov', number(camera.fieldOfView)]);
  }
  for (const [name, value] of Object.entries(settings)) parts.push([SETTING + name, value]);
  const plain = (text: string): string => encodeURIComponent(text).replace(/%2C/g, ',').replace(/%2F/g, '/');
  return parts.map(([name, value]) => `${plain(name)}=${plain(value)}`).join('&');
}

/** What of it can be read; a camera that is none is left out. */
export function viewOfFragment(fragment: string): AddressedView {
  const text = fragment.replace(/^#/, '');
  if (text === '' || text.length > LONGEST) return NO_VIEW;
  const fields = new URLSearchParams(text);
  const settings: Record<string, string> = {};
  for (const [name, value] of fields) if (name.startsWith(SETTING)) settings[name.slice(SETTING.length)] = value;
  return { scene: fields.get('scene') ?? '', camera: cameraOf(fields), settings };
}

function cameraOf(fields: URLSearchParams): Camera | null {
  const position = vectorOf(fields.get('at'));
  const forward = vectorOf(fields.get('look'));
  const up = vectorOf(fields.get('up')) ?? [0, 1, 0];
  const fieldOfView = Number(fields.get('fov') ?? 60);
  if (position === null || forward === null || length(forward) < 1e-6) return null;
  if (!(fieldOfView >= FIELD_OF_VIEW_LOW && fieldOfView <= FIELD_OF_VIEW_HIGH)) return null;
  const ahead = normalize(forward);
  if (length(cross(ahead, up)) < 1e-6) return null; // no way to say which side is up
  return { position, forward: ahead, up: normalize(subtract(up, scale(ahead, dot(up, ahead)))), fieldOfView };
}

function vectorOf(text: string | null): Vec3 | null {
  const [x, y, z, more] = (text ?? '').split(',').map((part) => (part.trim() === '' ? NaN : Number(part)));
  if (x === undefined || y === undefined || z === undefined || more !== undefined) return null;
  return [x, y, z].every(Number.isFinite) ? [x, y, z] : null;
}

/** As text, those of `rows` whose value is not the server's own. */
export function changedSettings(
  rows: readonly SettingRow[],
  value: (row: SettingRow) => SettingValue | undefined,
  isDefault: (row: SettingRow) => boolean,
): Readonly<Record<string, string>> {
  const text = (row: SettingRow): string => {
    const present = value(row);
    return typeof present === 'boolean' ? (present ? 'on' : 'off') : String(present);
  };
  return Object.fromEntries(rows.filter((row) => !isDefault(row)).map((row) => [row.name, text(row)]));
}

/** Values of the right type; what the table does not know, or does not allow, is left out. */
export function settingValues(rows: readonly SettingRow[], texts: Readonly<Record<string, string>>): SettingValues {
  const known = rows.map((row) => [row.name, valueOf(row, texts[row.name])] as const);
  return Object.fromEntries(known.filter(([, value]) => value !== null)) as SettingValues;
}

function valueOf(row: SettingRow, text: string | undefined): SettingValue | null {
  if (text === undefined) return null;
  if (row.type === 'bool') return text === 'on' ? true : text === 'off' ? false : null;
  if (row.type === 'choice') return row.choices.includes(text) ? text : null;
  const value = text.trim() === '' ? NaN : Number(text);
  return value >= row.low && value <= row.high ? value : null;
}
