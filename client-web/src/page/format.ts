// Numbers as people read them. Every figure comes with its unit; a dash stands for "not known yet".

export const UNKNOWN = '–';

/** 12.3 below 100, 123 above. */
export function compact(value: number, digits = 1): string {
  return Math.abs(value) >= 100 ? value.toFixed(0) : value.toFixed(digits);
}

export const milliseconds = (value: number | null): string => (value === null ? UNKNOWN : `${compact(value)} ms`);

/** Milliseconds, as microseconds below 0.1 ms. */
export const duration = (ms: number): string =>
  ms > 0 && ms < 0.0995 ? `${(ms * 1000).toFixed(ms < 0.00995 ? 1 : 0)} µs` : `${compact(ms, ms < 10 ? 2 : 1)} ms`;

/** Counts with k, M, G: 1.30 M, 912 k, 64. */
export function count(value: number): string {
  const units = ['', ' k', ' M', ' G', ' T'];
  let index = 0;
  let rest = value;
  while (rest >= 999.5 && index < units.length - 1) {
    rest /= 1000;
    index += 1;
  }
  const digits = index === 0 || rest >= 100 ? 0 : rest >= 10 ? 1 : 2;
  return rest.toFixed(digits) + units[index]!;
}

/** A whole number with thin spaces between thousands. */
export const whole = (value: number): string =>
  Math.round(value)
    .toString()
    .replace(/\B(?=(\d{3})+$)/g, '\u202f');

export function bytes(value: number): string {
  if (value >= 1e9) return `${(value / 1e9).toFixed(2)} GB`;
  return value >= 1e6 ? `${(value / 1e6).toFixed(0)} MB` : `${(value / 1e3).toFixed(0)} kB`;
}

/** A share as per cent, with two significant digits when small. */
export function percent(share: number): string {
  const value = share * 100;
  return `${value >= 10 ? value.toFixed(0) : value >= 1 ? value.toFixed(1) : value.toFixed(2)} %`;
}

/** A setting's number: no trailing zeros, no rounding noise of 32-bit floats. */
export const settingNumber = (value: number): string => String(Number(value.toPrecision(6)));

/** A unit of the server's table as people read it. */
export const unitWord = (unit: string): string => ({ deg: 'degrees', x: '×' })[unit] ?? unit;
