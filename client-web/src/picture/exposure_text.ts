// An automatic exposure in words.

/** EV with its sign, to a tenth: "+1.3 EV". */
export function exposureText(ev: number): string {
  const shown = Math.abs(ev) < 0.05 ? '0.0' : Math.abs(ev).toFixed(1);
  return `${ev < -0.05 ? '−' : '+'}${shown} EV`;
}
