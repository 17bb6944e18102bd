// Reads values out of JSON from the server: each helper answers a typed value or a harmless stand-in for one.

import type { SettingValue, SettingValues } from './protocol.js';

export type Fields = Readonly<Record<string, unknown>>;
export type Numbers = Readonly<Record<string, number>>;

export const isObject = (value: unknown): value is Fields =>
  typeof value === 'object' && value !== null && !Array.isArray(value);
export const fieldsOf = (value: unknown): Fields => (isObject(value) ? value : {});
export const listOf = (value: unknown): readonly unknown[] => (Array.isArray(value) ? value : []);
export const textOf = (value: unknown): string => (typeof value === 'string' ? value : '');
export const numberOf = (value: unknown, fallback = 0): number =>
  typeof value === 'number' && Number.isFinite(value) ? value : fallback;

export function numbersOf(value: unknown): Numbers {
  const numbers: Record<string, number> = {};
  for (const [name, entry] of Object.entries(fieldsOf(value))) {
    if (typeof entry === 'number' && Number.isFinite(entry)) numbers[name] = entry;
  }
  return numbers;
}

export function settingValuesOf(value: unknown): SettingValues {
  const values: Record<string, SettingValue> = {};
  for (const [name, entry] of Object.entries(fieldsOf(value))) {
    if (typeof entry === 'boolean' || typeof entry === 'number' || typeof entry === 'string') values[name] = entry;
  }
  return values;
}
