// Shows who made what of the picture: a tint over every cell in its device's colour, and a card with the devices' shares
// and the timeline of their workers.

import { deviceColor, rgbOf } from '../device_colors.js';
import { el, setText } from '../../page/dom.js';
import { percent } from '../../page/format.js';
import { borderLines, describePartition, pixelShares } from './partition.js';
import { NOBODY, type Partition } from '../../wire/partition_message.js';
import { pictureBox, type Box } from '../../picture/picture_box.js';
import { TimelineView } from './timeline_view.js';
import type { Viewer } from '../../viewer.js';
import './partition_view.css';

const TINT = 0.35;
const BORDER = 'rgb(255 255 255 / 65%)';
const WORDS_MS = 1000; // the summary for screen readers changes no faster

export class PartitionView {
  /** Lies over the picture. */
  readonly overlay = el('canvas', { class: 'map-overlay partition-overlay', 'aria-hidden': 'true', hidden: true });
  readonly card: HTMLElement;
  private readonly legend_ = el('ul', { class: 'legend' });
  private readonly summary_ = el('p', { class: 'sr-only' });
  private readonly timeline_ = new TimelineView();
  private readonly cells_ = document.createElement('canvas'); // one pixel per cell
  private legendOf_ = '';
  private saidAt_ = -Infinity;

  constructor(
    private readonly viewer_: Viewer,
    announce: (text: string) => void,
  ) {
    this.card = el(
      'section',
      { class: 'map-card partition-card', 'aria-label': 'Who made the picture', hidden: true },
      this.legend_,
      this.timeline_.element,
      this.summary_,
    );
    viewer_.on(['partition'], () => this.refresh());
    window.addEventListener('resize', () => this.refresh());
    let wanted = false;
    viewer_.on(['settings'], () => {
      const now = viewer_.settings.value('showPartition') === true;
      if (now !== wanted) announce(now ? 'The partition is shown.' : 'The partition is hidden.');
      wanted = now;
    });
  }

  private refresh(): void {
    const shown = this.viewer_.partition.shown;
    this.overlay.hidden = shown === null;
    this.card.hidden = shown === null;
    if (shown === null) {
      this.saidAt_ = -Infinity;
      return;
    }
    const { map: partition, frame } = shown;
    this.drawOverlay(partition, pictureBox(frame.width, frame.height, window.innerWidth, window.innerHeight));
    this.refreshLegend(partition);
    this.timeline_.show(partition.timeline);
    const now = performance.now();
    if (now - this.saidAt_ < WORDS_MS) return;
    this.saidAt_ = now;
    const words = describePartition(partition);
    setText(this.summary_, words);
    this.timeline_.describe(`Timeline of the workers. ${words}`);
  }

  /** `box`: of the picture in the window. Cells at the right and lower edge reach beyond it and are cut off. */
  private drawOverlay(partition: Partition, box: Box): void {
    const ratio = window.devicePixelRatio;
    const width = Math.round(window.innerWidth * ratio);
    const height = Math.round(window.innerHeight * ratio);
    if (this.overlay.width !== width || this.overlay.height !== height) {
      this.overlay.width = width;
      this.overlay.height = height;
    }
    const context = this.overlay.getContext('2d');
    if (context === null) return;
    const across = (box.width / partition.width) * ratio; // device pixels per rendered one
    const down = (box.height / partition.height) * ratio;
    context.setTransform(1, 0, 0, 1, 0, 0);
    context.clearRect(0, 0, width, height);
    context.translate(box.x * ratio, box.y * ratio);
    context.save();
    context.beginPath();
    context.rect(0, 0, box.width * ratio, box.height * ratio);
    context.clip();
    this.paintCells(partition);
    context.imageSmoothingEnabled = false;
    const { columns, rows, cellWidth, cellHeight } = partition;
    context.drawImage(this.cells_, 0, 0, columns * cellWidth * across, rows * cellHeight * down);
    context.strokeStyle = BORDER;
    context.lineWidth = Math.max(1, Math.round(ratio));
    context.beginPath();
    for (const line of borderLines(partition)) {
      context.moveTo(line.x0 * across, line.y0 * down);
      context.lineTo(line.x1 * across, line.y1 * down);
    }
    context.stroke();
    context.restore();
  }

  private paintCells({ columns, rows, owners, devices }: Partition): void {
    this.cells_.width = columns;
    this.cells_.height = rows;
    const context = this.cells_.getContext('2d');
    if (context === null) return;
    const image = context.createImageData(columns, rows);
    const colors = devices.map((device) => rgbOf(deviceColor(device)));
    owners.forEach((owner, i) => {
      if (owner === NOBODY) return;
      image.data.set(colors[owner]!, 4 * i);
      image.data[4 * i + 3] = Math.round(255 * TINT);
    });
    context.putImageData(image, 0, 0);
  }

  private refreshLegend(partition: Partition): void {
    const shares = pixelShares(partition);
    const names = [...partition.devices, ...(shares[partition.devices.length]! > 0 ? ['nobody'] : [])];
    if (names.join('\n') !== this.legendOf_) {
      this.legendOf_ = names.join('\n');
      this.legend_.replaceChildren(
        ...names.map((name) => {
          const swatch = el('span', { class: 'swatch', 'aria-hidden': 'true' });
          if (name !== 'nobody') swatch.style.setProperty('--device', deviceColor(name));
          return el('li', {}, swatch, el('span', {}, name), el('span', { class: 'figure' }));
        }),
      );
    }
    [...this.legend_.children].forEach((row, i) => setText(row.lastElementChild!, percent(shares[i]!)));
  }
}

/** Shows or hides who made which part of the picture. */
export function togglePartition(viewer: Viewer): void {
  const shown = viewer.settings.value('showPartition');
  if (shown !== undefined) return viewer.setSettings({ showPartition: shown !== true });
  viewer.onMessage({ kind: 'notice', text: 'This server cannot say which device made which part of the picture.' });
}
