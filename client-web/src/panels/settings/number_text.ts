// Numbers as people type them: with a decimal comma or point, spaces or the other sign between thousands. Knows no DOM.

/** Null for what is no number. A lone comma or point is the decimal one. */
export function parseNumber(text: string): number | null {
  const plain = text.trim().replace(/[\s\u202f\u00a0_']/g, '').replace(/\u2212/g, '-');
  if (!/^[-+]?[\d.,]*\d[\d.,]*(e[-+]?\d+)?$/i.test(plain)) return null;
  const last = Math.max(plain.lastIndexOf(','), plain.lastIndexOf('.'));
  const decimal = last < 0 ? '' : plain.charAt(last);
  const other = decimal === ',' ? '.' : ',';
  if (decimal !== '' && plain.split(decimal).length > 2) {
    // 1,234,567: thousands, unless both signs come more than once
    return plain.includes(other) ? null : finite(plain.split(decimal).join(''));
  }
  return finite(plain.split(other).join('').replace(',', '.'));
}

function finite(text: string): number | null {
  const value = Number(text);
  return Number.isFinite(value) ? value : null;
}
