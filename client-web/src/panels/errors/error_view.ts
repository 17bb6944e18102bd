// Shows where the picture still has how much error: a tint over every cell, and a card with what the colours mean.

import { el, setText } from '../../page/dom.js';
import { percent } from '../../page/format.js';
import { pictureBox } from '../../picture/picture_box.js';
import type { ErrorMap } from '../../wire/errors_message.js';
import type { Viewer } from '../../viewer.js';
import { rgbOf } from '../device_colors.js';
import { describeErrors, LEVEL_COLORS, LEVEL_NAMES, levelOf, levelShares } from './error_levels.js';
import type { Shown } from '../shown_map.js';
import './error_view.css';

const TINT = 0.55;
const WORDS_MS = 1000; // the summary for screen readers changes no faster

export class ErrorView {
  /** Lies over the picture. */
  readonly overlay = el('canvas', { class: 'map-overlay error-overlay', 'aria-hidden': 'true', hidden: true });
  readonly card: HTMLElement;
  private readonly shares_ = LEVEL_NAMES.map(() => el('span', { class: 'figure' }));
  private readonly summary_ = el('p', { class: 'sr-only' });
  private saidAt_ = -Infinity;

  constructor(
    private readonly viewer_: Viewer,
    announce: (text: string) => void,
  ) {
    const rows = LEVEL_NAMES.map((name, level) => {
      const swatch = el('span', { class: 'swatch', 'aria-hidden': 'true' });
      swatch.style.setProperty('--device', LEVEL_COLORS[level]!);
      return el('li', {}, swatch, el('span', {}, name), this.shares_[level]!);
    });
    const legend = el('ul', { class: 'legend' }, ...rows);
    const label = 'Error of each part of the picture';
    this.card = el('section', { class: 'map-card error-card', 'aria-label': label, hidden: true }, legend, this.summary_);
    viewer_.on(['errors'], () => this.refresh());
    viewer_.on(['connection', 'scene'], () => viewer_.errors.forget());
    window.addEventListener('resize', () => this.refresh());
    let wanted = false;
    viewer_.on(['settings'], () => {
      viewer_.errors.settingsChanged();
      const now = viewer_.settings.value('showError') === true;
      if (now !== wanted) announce(now ? 'The error is shown.' : 'The error is hidden.');
      wanted = now;
    });
  }

  private refresh(): void {
    const shown = this.viewer_.errors.shown;
    this.overlay.hidden = shown === null;
    this.card.hidden = shown === null;
    if (shown === null) {
      this.saidAt_ = -Infinity;
      return;
    }
    this.drawOverlay(shown);
    levelShares(shown.map).forEach((share, level) => setText(this.shares_[level]!, percent(share)));
    const now = performance.now();
    if (now - this.saidAt_ < WORDS_MS) return;
    this.saidAt_ = now;
    setText(this.summary_, describeErrors(shown.map));
  }

  /** Cells at the right and lower edge reach beyond the picture and are cut off. */
  private drawOverlay({ map, frame }: Shown<ErrorMap>): void {
    const ratio = window.devicePixelRatio;
    this.overlay.width = Math.round(window.innerWidth * ratio); // clears it
    this.overlay.height = Math.round(window.innerHeight * ratio);
    const context = this.overlay.getContext('2d');
    if (context === null) return;
    const box = pictureBox(frame.width, frame.height, window.innerWidth, window.innerHeight);
    context.scale(ratio, ratio);
    context.translate(box.x, box.y);
    context.beginPath();
    context.rect(0, 0, box.width, box.height);
    context.clip();
    context.imageSmoothingEnabled = false;
    const across = (map.columns * map.cellWidth * box.width) / map.width;
    const down = (map.rows * map.cellHeight * box.height) / map.height;
    context.drawImage(cellsOf(map), 0, 0, across, down);
  }
}

/** One pixel per cell. */
function cellsOf({ columns, rows, cells }: ErrorMap): HTMLCanvasElement {
  const canvas = document.createElement('canvas');
  canvas.width = columns;
  canvas.height = rows;
  const context = canvas.getContext('2d');
  if (context === null) return canvas;
  const image = context.createImageData(columns, rows);
  const colors = LEVEL_COLORS.map(rgbOf);
  cells.forEach((error, i) => {
    if (error === null) return;
    image.data.set(colors[levelOf(error)]!, 4 * i);
    image.data[4 * i + 3] = Math.round(255 * TINT);
  });
  context.putImageData(image, 0, 0);
  return canvas;
}

/** Shows or hides where the error is. */
export function toggleErrors(viewer: Viewer): void {
  const shown = viewer.settings.value('showError');
  if (shown !== undefined) return viewer.setSettings({ showError: shown !== true });
  viewer.onMessage({ kind: 'notice', text: 'This server cannot say where in the picture the error is.' });
}
