// An angle as a dial to drag, with the number beside it.

import { drawn, el } from '../../page/dom.js';
import { settingNumber, unitWord } from '../../page/format.js';
import { numberControl, type ControlMaker } from '../settings/settings_field.js';
import { angleAt, turnedTo, TURN_SCALE } from './light_scale.js';

const MARKS = Array.from({ length: 8 }, (_, i) => 45 * i);

/** A ring with marks, and a hand that is turned with the value. */
function face(): { readonly svg: SVGSVGElement; readonly hand: SVGElement } {
  const mark = (angle: number): SVGElement =>
    drawn('path', { class: 'dial-mark', d: 'M32 5v4', transform: `rotate(${angle} 32 32)` });
  const hand = drawn(
    'g',
    { class: 'dial-hand' },
    drawn('path', { d: 'M32 32V19' }),
    drawn('circle', { cx: 32, cy: 14, r: 5 }),
  );
  const ring = drawn('circle', { class: 'dial-ring', cx: 32, cy: 32, r: 29 });
  const body = drawn('circle', { class: 'dial-body', cx: 32, cy: 32, r: 6 });
  const svg = drawn('svg', { viewBox: '0 0 64 64', 'aria-hidden': 'true' }, ring, ...MARKS.map(mark), hand, body);
  return { svg, hand };
}

/**
 * `hint`: how else the angle is turned. `fromBelow`: nought is at the lowest point and the angle grows to the right, as in a
 * plan whose lower edge is at the viewer; else it is at the top and grows clockwise.
 */
export const dialControl =
  (hint: string, fromBelow = false): ControlMaker =>
  (row, id, hooks) => {
    const number = numberControl(row, id, hooks, TURN_SCALE);
    const placed = (angle: number): number => (fromBelow ? 180 - angle : angle); // its own inverse
    const { svg, hand } = face();
    const limits = { 'aria-valuemin': row.low, 'aria-valuemax': row.high };
    const dial = el('div', { class: 'dial', role: 'slider', tabindex: 0, 'aria-label': row.label, ...limits }, svg);
    const drag = (event: PointerEvent): void => {
      if (!dial.hasPointerCapture(event.pointerId)) return;
      const box = dial.getBoundingClientRect();
      const angle = angleAt(event.clientX - box.left - box.width / 2, event.clientY - box.top - box.height / 2);
      if (angle !== null && turnedTo(row, placed(angle)) !== number.value()) hooks.changed(turnedTo(row, placed(angle)));
    };
    dial.addEventListener('pointerdown', (event) => {
      if (event.button !== 0 || dial.getAttribute('aria-disabled') === 'true') return;
      dial.setPointerCapture(event.pointerId);
      drag(event);
    });
    dial.addEventListener('pointermove', drag);
    dial.addEventListener('keydown', (event) => {
      if (dial.getAttribute('aria-disabled') !== 'true') number.keys(event);
    });
    const typed = el('div', { class: 'dial-number' }, number.input, el('span', { class: 'unit' }, unitWord(row.unit)));
    const said = el('span', { class: 'muted dial-hint' }, hint);
    return {
      control: number.input,
      inline: [],
      below: [el('div', { class: 'dial-row' }, dial, el('div', { class: 'dial-side' }, typed, said))],
      show: (value) => {
        if (typeof value !== 'number') return;
        number.show(value);
        hand.setAttribute('transform', `rotate(${placed(value)} 32 32)`);
        dial.setAttribute('aria-valuenow', settingNumber(value));
        dial.setAttribute('aria-valuetext', `${settingNumber(value)} ${unitWord(row.unit)}`);
      },
    };
  };
