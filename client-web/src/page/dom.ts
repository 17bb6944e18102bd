// Small helpers to build the page. No markup strings: everything is made as nodes, as the content policy asks.

type Attributes = Readonly<Record<string, string | number | boolean>>;
type Child = Node | string | null;

function apply(element: Element, attributes: Attributes): void {
  for (const [name, value] of Object.entries(attributes)) {
    if (value === false) continue;
    element.setAttribute(name, value === true ? '' : String(value));
  }
}

/** A new element; attributes that are `false` are left out, `true` is an empty attribute. */
export function el<K extends keyof HTMLElementTagNameMap>(
  tag: K,
  attributes: Attributes = {},
  ...children: Child[]
): HTMLElementTagNameMap[K] {
  const element = document.createElement(tag);
  apply(element, attributes);
  for (const child of children) if (child !== null) element.append(child);
  return element;
}

/** Changes text only when it differs, so that nothing is laid out in vain. */
export function setText(element: Element, text: string): void {
  if (element.textContent !== text) element.textContent = text;
}

let lastId = 0;
/** An id that is unique in the page. */
export function uniqueId(prefix: string): string {
  lastId += 1;
  return `${prefix}-${lastId}`;
}

/** 24 x 24 line drawings: each string is the `d` of one stroked path. */
const ICONS = {
  sun: [
    'M12 8a4 4 0 1 0 0 8 4 4 0 0 0 0-8z',
    'M12 2v2.5M12 19.5V22M2 12h2.5M19.5 12H22M5 5l1.7 1.7M17.3 17.3L19 19M19 5l-1.7 1.7M6.7 17.3L5 19',
  ],
  bulb: [
    'M12 3a6.5 6.5 0 0 0-3.8 11.8c.7.6 1.1 1.3 1.1 2.2h5.4c0-.9.4-1.6 1.1-2.2A6.5 6.5 0 0 0 12 3z',
    'M9.5 20.5h5',
  ],
  chevron: ['M6 9l6 6 6-6'],
  camera: ['M3 8h4l2-3h6l2 3h4v11H3z', 'M12 10a3.5 3.5 0 1 0 0 7 3.5 3.5 0 0 0 0-7z'],
  save: ['M12 4v11M7.5 11l4.5 4.5 4.5-4.5', 'M4 19.5h16'],
  play: ['M7 4.5v15l12-7.5z'],
  stop: ['M6 6h12v12H6z'],
  sliders: ['M4 7h9M17 7h3M4 17h3M11 17h9', 'M15 5a2 2 0 1 0 0 4 2 2 0 0 0 0-4z', 'M9 15a2 2 0 1 0 0 4 2 2 0 0 0 0-4z'],
  chart: ['M4 20V10M10 20V4M16 20v-8M22 20H2'],
  help: ['M12 3a9 9 0 1 0 0 18 9 9 0 0 0 0-18z', 'M9.6 9.4a2.5 2.5 0 1 1 3.5 2.3c-.8.4-1.1.9-1.1 1.8M12 16.6v.2'],
  hide: ['M3 12s3.5-6 9-6 9 6 9 6-3.5 6-9 6-9-6-9-6z', 'M4 20L20 4'],
  show: ['M3 12s3.5-6 9-6 9 6 9 6-3.5 6-9 6-9-6-9-6z', 'M12 9.5a2.5 2.5 0 1 0 0 5 2.5 2.5 0 0 0 0-5z'],
  info: ['M12 3a9 9 0 1 0 0 18 9 9 0 0 0 0-18z', 'M12 11v5.5M12 7.6v.2'],
  warning: ['M12 4L2.5 20h19z', 'M12 10v5M12 17.3v.2'],
  reset: ['M4.5 12a7.5 7.5 0 1 0 2.4-5.5L4.5 8.7', 'M4.5 4v4.7h4.7'],
  frame: ['M4 9V4h5M15 4h5v5M20 15v5h-5M9 20H4v-5', 'M12 9a3 3 0 1 0 0 6 3 3 0 0 0 0-6z'],
  full: ['M9 4H4v5M15 4h5v5M4 15v5h5M20 15v5h-5'],
  link: [
    'M10 14a4 4 0 0 0 6 .4l3-3a4 4 0 0 0-5.7-5.7l-1.3 1.3',
    'M14 10a4 4 0 0 0-6-.4l-3 3a4 4 0 0 0 5.7 5.7l1.3-1.3',
  ],
  undo: ['M9 5L4 10l5 5', 'M4 10h10a6 6 0 0 1 0 12h-3'],
  close: ['M6 6l12 12M18 6L6 18'],
  fly: ['M3 11l18-7-7 17-2.5-7.5z'],
  orbit: [
    'M12 9.5a2.5 2.5 0 1 0 0 5 2.5 2.5 0 0 0 0-5z',
    'M12 7c5 0 9.5 2.2 9.5 5s-4.5 5-9.5 5-9.5-2.2-9.5-5S7 7 12 7z',
  ],
  sparkle: ['M11 3l2 6 6 2-6 2-2 6-2-6-6-2 6-2z', 'M19 16.5v5M16.5 19h5'],
  scatter: ['M4 4v16h16', 'M7.5 7.5v.2M9.5 12c2 3 5 4 9.5 4.5M15 9v.2M18.5 12.5v.2M12 6v.2'],
  layers: ['M12 3l9 5-9 5-9-5z', 'M3 12l9 5 9-5M3 16l9 5 9-5'],
  clock: ['M12 3a9 9 0 1 0 0 18 9 9 0 0 0 0-18z', 'M12 7.5V12l3 2'],
  target: ['M12 5a7 7 0 1 0 0 14 7 7 0 0 0 0-14z', 'M12 2v6M12 16v6M2 12h6M16 12h6'],
  ruler: ['M3 16L16 3l5 5L8 21z', 'M7 12l2 2M10 9l3 3M13 6l2 2'],
  check: ['M5 12.5l4.5 4.5L19 7.5'],
} as const;

export type IconName = keyof typeof ICONS;

/** A new element of a drawing. */
export function drawn<K extends keyof SVGElementTagNameMap>(
  tag: K,
  attributes: Attributes = {},
  ...children: Child[]
): SVGElementTagNameMap[K] {
  const element = document.createElementNS('http://www.w3.org/2000/svg', tag);
  apply(element, attributes);
  for (const child of children) if (child !== null) element.append(child);
  return element;
}

export const icon = (name: IconName): SVGSVGElement =>
  drawn(
    'svg',
    { viewBox: '0 0 24 24', class: 'icon', 'aria-hidden': 'true' },
    ...ICONS[name].map((d) => drawn('path', { d })),
  );

/** A button with an icon and, where there is room, a visible label; `hint` adds the key to the tooltip. */
export function iconButton(name: IconName, label: string, hint: string, className: string): HTMLButtonElement {
  const title = hint === '' ? label : `${label} (${hint})`;
  return el('button', { type: 'button', class: className, title }, icon(name), el('span', { class: 'label' }, label));
}
