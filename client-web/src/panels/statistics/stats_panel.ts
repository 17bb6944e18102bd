// What the stream does, in figures: rate and delay, where a frame's time goes, rays, progress at rest, devices.

import { exposureText } from '../../picture/exposure_text.js';
import { autopilotRows, autopilotTitle } from './autopilot_rows.js';
import { BarList } from './bar_list.js';
import { FrameChart } from './chart.js';
import { FrameTimeline } from './frame_timeline.js';
import { deviceColor, kindOf } from '../device_colors.js';
import { poolRows, poolTitle } from './pool_rows.js';
import { deviceRows, schedulerFacts } from './device_rows.js';
import { el, setText } from '../../page/dom.js';
import { bytes, compact, count, milliseconds, percent, UNKNOWN, whole } from '../../page/format.js';
import { Window } from '../../picture/latency.js';
import { forecastText, refinedText } from '../../picture/forecast_text.js';
import { waitText } from '../../picture/time_left.js';
import { frameSizeText } from '../../picture/resolution.js';
import type { Panel } from '../panel.js';
import type { Frame } from '../../wire/frame.js';
import type { Stats } from '../../wire/protocol.js';
import type { Numbers } from '../../wire/fields.js';
import type { Viewer } from '../../viewer.js';
import './stats_panel.css';

const REFRESH_MS = 250;
/** Without a frame for this long the picture counts as resting, ms; after its last one, and while it may still refine. */
const IDLE_AFTER = 1500;
const REFINING_IDLE_AFTER = 15_000;

const STAGES: readonly { readonly name: string; readonly label: string; readonly help: string }[] = [
  { name: 'queue', label: 'Waiting', help: 'From the input to the start of tracing' },
  { name: 'render', label: 'Tracing', help: 'Rays and shading of the pass' },
  { name: 'develop', label: 'Developing', help: 'Film to picture: exposure and tone curve' },
  { name: 'encode', label: 'Encoding', help: 'Picture to JPEG' },
  { name: 'send', label: 'Sending', help: 'From encoded to written to the network' },
  { name: 'network', label: 'Network', help: 'There and back, measured by a ping' },
  { name: 'decode', label: 'Decoding', help: 'JPEG to pixels in this browser' },
];

/** Of the kinds that the panel lists, in the order in which the server sends them. */
const RAY_LABELS: Readonly<Record<string, string>> = {
  primary: 'Camera',
  shadow: 'Shadow',
  ambient_occlusion: 'Occlusion',
  reflection: 'Reflection',
  refraction: 'Refraction',
  total: 'Total',
};

class Figure {
  readonly value = el('span', { class: 'big-value' }, UNKNOWN);
  readonly detail = el('span', { class: 'big-detail' }, '\u00a0');
  readonly element: HTMLElement;

  constructor(label: string, unit: string, help: string) {
    const head = el('span', { class: 'big-label' }, label);
    this.element = el(
      'div',
      { class: 'big', title: help },
      head,
      el('span', { class: 'big-line' }, this.value, el('span', { class: 'unit' }, unit)),
      this.detail,
    );
  }
}

/** Two digits below ten, none where they would round to nothing. */
const rateText = (rate: number): string => (rate < 10 ? rate.toFixed(1) : rate.toFixed(0));

/** `target` 0: not known yet. */
const samplesText = (samples: number, target: number): string =>
  target > 0 ? `${whole(samples)} / ${whole(target)}` : whole(samples);

/** How many are at the server, and how many of them watch this view. */
const viewersText = ({ viewers, watchers }: Stats): string =>
  watchers === 0 ? whole(viewers) : `${whole(viewers)} (${whole(watchers)} ${watchers === 1 ? 'watches' : 'watch'} this view)`;

export class StatsPanel {
  private readonly rate_ = new Figure('Frames', '/s', 'Pictures shown per second');
  private readonly delay_ = new Figure(
    'Motion to photon',
    'ms',
    'From the input event to the first picture that shows it: median of the last 240. The screen adds one or two refreshes.',
  );
  private readonly rays_ = new Figure('Rays', 'M/s', 'Million rays per second while tracing');
  private readonly chart_ = new FrameChart();
  private readonly samples_ = el('span', { class: 'figure' });
  private readonly progress_ = el('progress', { max: 1, value: 0, 'aria-label': 'Samples so far' });
  private readonly error_ = el('span', { class: 'figure' });
  private readonly forecast_ = el('p', { class: 'forecast muted', hidden: true });
  private readonly hurry_ = new BarList();
  private readonly hurryTitle_ = el('h3', {});
  private readonly hurrySection_ = el('section', { class: 'stats-section hurry', hidden: true }, this.hurryTitle_, this.hurry_.element);
  private readonly stages_ = new BarList();
  private readonly timeline_ = new FrameTimeline();
  private readonly rayList_ = new BarList();
  private readonly devices_ = new BarList();
  private readonly pool_ = new BarList();
  private readonly poolTitle_ = el('h3', {});
  private readonly poolSection_ = el('section', { class: 'stats-section pool', hidden: true }, this.poolTitle_, this.pool_.element);
  private readonly facts_ = el('dl', { class: 'facts' });
  private readonly factValues_ = new Map<string, HTMLElement>();

  constructor(
    private readonly panel_: Panel,
    private readonly viewer_: Viewer,
  ) {
    const section = (title: string, ...content: HTMLElement[]): HTMLElement =>
      el('section', { class: 'stats-section' }, el('h3', {}, title), ...content);
    const line = (label: string, value: HTMLElement): HTMLElement =>
      el('div', { class: 'line' }, el('span', {}, label), value);
    panel_.body.append(
      el('div', { class: 'bigs' }, this.rate_.element, this.delay_.element, this.rays_.element),
      this.chart_.element,
      el(
        'section',
        { class: 'stats-section' },
        line('Samples per pixel', this.samples_),
        this.progress_,
        line('Relative error', this.error_),
        this.forecast_,
      ),
      this.hurrySection_,
      section('Time of a frame', this.stages_.element),
      section('Where the time went, frame by frame', this.timeline_.element),
      section('Rays of the last pass', this.rayList_.element),
      section('Tiles by device', this.devices_.element),
      this.poolSection_,
      this.facts_,
    );
    window.setInterval(() => this.refresh(), REFRESH_MS);
    panel_.onToggle(() => this.refresh());
  }

  private refresh(): void {
    if (document.hidden) return;
    const rate = this.shownRate();
    this.refreshSummary(rate);
    if (!this.panel_.isOpen) return;
    this.refreshFigures(rate);
    this.chart_.draw(this.viewer_.stream.frameIntervals.values);
    this.refreshSamples();
    this.refreshHurry();
    this.refreshStages();
    this.timeline_.draw(this.viewer_.stream.trace.frames);
    this.refreshRays(this.viewer_.state.stats?.rays ?? {});
    this.refreshDevices();
    this.refreshPool();
    this.refreshFacts();
  }

  /** Frames shown per second, null while the picture rests. */
  private shownRate(): number | null {
    const done = this.viewer_.state.lastFrame?.final ?? true;
    return this.viewer_.stream.shownRate(performance.now(), done ? IDLE_AFTER : REFINING_IDLE_AFTER);
  }

  private refreshSummary(rate: number | null): void {
    const { lastFrame, connection } = this.viewer_.state;
    if (connection.name !== 'open' || lastFrame === null) return setText(this.panel_.summary, 'no picture yet');
    const median = this.viewer_.stream.motionToPhoton.window.quantile(0.5);
    const parts = [rate === null ? 'at rest' : `${rateText(rate)} /s`, median === null ? '' : milliseconds(median)];
    setText(this.panel_.summary, parts.filter((part) => part !== '').join(' · '));
  }

  private refreshFigures(rate: number | null): void {
    const { stats } = this.viewer_.state;
    setText(this.rate_.value, rate === null ? UNKNOWN : rateText(rate));
    setText(this.rate_.detail, rate === null ? 'at rest' : 'shown');
    const window = this.viewer_.stream.motionToPhoton.window;
    const median = window.quantile(0.5);
    const p95 = window.quantile(0.95);
    setText(this.delay_.value, median === null ? UNKNOWN : compact(median, 0));
    setText(this.delay_.detail, p95 === null ? 'move to measure' : `95 %: ${compact(p95, 0)} ms`);
    setText(this.rays_.value, stats === null ? UNKNOWN : compact(stats.mraysPerSecond));
    setText(this.rays_.detail, stats === null || stats.device === '' ? '\u00a0' : stats.device);
    const known = stats !== null && kindOf(stats.device) !== undefined;
    this.rays_.detail.style.setProperty('--device', known ? deviceColor(stats.device) : '');
  }

  private refreshSamples(): void {
    const { lastFrame, stats } = this.viewer_.state;
    const samples = lastFrame?.samples ?? 0;
    const target = stats?.targetSamples ?? Number(this.viewer_.settings.confirmed('samples') ?? 0);
    const left = lastFrame?.final === false ? this.viewer_.stream.timeLeft.until(target, performance.now()) : null;
    const wait = left === null ? '' : ` · ${waitText(left)} left`;
    setText(this.samples_, lastFrame === null ? UNKNOWN : samplesText(samples, target) + wait);
    this.progress_.value = target > 0 ? Math.min(1, samples / target) : 0;
    const error = lastFrame?.relativeError ?? 1;
    const reached = lastFrame?.errorReached === true ? ' · target reached' : '';
    setText(this.error_, error >= 1 ? UNKNOWN : percent(error) + (reached || refinedText(lastFrame?.final ?? true, stats?.refined ?? 1)));
    const ahead = lastFrame?.moving === false ? forecastText(stats?.forecast ?? null, !lastFrame.final, target) : '';
    setText(this.forecast_, ahead);
    this.forecast_.hidden = ahead === '';
  }

  /** What is left out for the time budget. */
  private refreshHurry(): void {
    const autopilot = this.viewer_.state.stats?.autopilot ?? null;
    this.hurrySection_.hidden = autopilot === null;
    setText(this.hurryTitle_, autopilotTitle(autopilot));
    const labels = this.viewer_.settings.rows;
    const rows = autopilotRows(autopilot, (setting) => labels.find(({ name }) => name === setting)?.label ?? setting);
    this.hurry_.keep(rows.map(([name]) => name));
    for (const [name, row] of rows) this.hurry_.row(name, row);
  }

  private refreshStages(): void {
    const frames = this.viewer_.stream.recentFrames;
    const median = (value: (frame: Frame) => number): number | null => {
      const window = new Window(frames.length + 1);
      for (const frame of frames) window.push(value(frame));
      return window.quantile(0.5);
    };
    const times: Readonly<Record<string, number | null>> = {
      queue: median((frame) => frame.queueMs),
      render: median((frame) => frame.renderMs),
      develop: median((frame) => frame.developMs),
      encode: median((frame) => frame.encodeMs),
      send: median((frame) => frame.sendMs),
      network: this.viewer_.stream.roundTrips.quantile(0.5),
      decode: this.viewer_.stream.decodeMs.quantile(0.5),
    };
    const longest = Math.max(1, ...Object.values(times).map((time) => time ?? 0));
    const [device, other] = this.viewer_.state.lastFrame?.devices ?? [];
    for (const { name, label, help } of STAGES) {
      const time = times[name] ?? null;
      const alone = name === 'render' && device !== undefined && other === undefined;
      const color = alone ? deviceColor(device) : '';
      this.stages_.row(name, { label, share: (time ?? 0) / longest, text: milliseconds(time), color, help });
    }
  }

  private refreshRays(rays: Numbers): void {
    const total = rays['total'] ?? Object.values(rays).reduce((sum, value) => sum + value, 0);
    for (const [name, value] of Object.entries(rays)) {
      const label = RAY_LABELS[name];
      if (label === undefined) continue;
      const share = name === 'total' ? null : total > 0 ? value / total : 0;
      this.rayList_.row(name, { label, share, text: count(value) });
    }
  }

  private refreshDevices(): void {
    const { stats } = this.viewer_.state;
    const rows = stats === null ? [] : deviceRows(stats.tiles, stats.parts, this.viewer_.state.lastFrame?.devices ?? []);
    this.devices_.keep(rows.map((row) => row.device));
    for (const { device, share, text, note } of rows) {
      this.devices_.row(device, { label: device, share, text, color: deviceColor(device), keyed: true, note });
    }
  }

  /** The render nodes of the server's pool. */
  private refreshPool(): void {
    const pool = this.viewer_.state.stats?.pool ?? null;
    this.poolSection_.hidden = pool === null;
    if (pool === null) return;
    setText(this.poolTitle_, poolTitle(pool));
    const rows = poolRows(pool, this.viewer_.state.stats?.parts ?? []);
    this.pool_.keep(rows.map(({ key }) => key));
    for (const { key, label, device, share, text, note } of rows) {
      const color = device === '' ? '' : deviceColor(device);
      this.pool_.row(key, { label, share, text, color, keyed: device !== '', note });
    }
  }

  private refreshFacts(): void {
    const { stats, lastFrame } = this.viewer_.state;
    const rate = this.viewer_.stream.receivedRate.amount(performance.now());
    this.fact('Picture', lastFrame === null ? UNKNOWN : frameSizeText(lastFrame));
    const exposure = stats?.autoExposure ?? null;
    if (exposure === null) this.dropFact('Automatic exposure');
    else this.fact('Automatic exposure', exposureText(exposure));
    this.fact('Data rate', `${((rate * 8) / 1e6).toFixed(1)} Mbit/s`);
    this.fact('Beside tracing', stats === null ? UNKNOWN : `${percent(stats.overheadShare)} of a frame`);
    this.fact('Viewers', stats === null ? UNKNOWN : viewersText(stats));
    this.fact('Server memory', stats === null ? UNKNOWN : bytes(stats.residentBytes));
    const bad = stats?.nonfiniteSamples ?? 0;
    const entry = this.fact('Non-finite samples', stats === null ? UNKNOWN : whole(bad));
    entry.classList.toggle('bad', bad > 0);
    const lost = (stats?.rays['media_underflows'] ?? 0) + (stats?.rays['media_overflows'] ?? 0);
    const inBodies = this.fact('Lost in bodies', stats === null ? UNKNOWN : whole(lost));
    inBodies.classList.toggle('bad', lost > 0);
    const scheduler = this.viewer_.settings.confirmed('device') === 'hybrid' || (stats?.pool ?? null) !== null ? (stats?.scheduler ?? null) : null;
    for (const [label, text] of schedulerFacts(scheduler)) {
      if (text === null) this.dropFact(label);
      else this.fact(label, text);
    }
  }

  private dropFact(label: string): void {
    const value = this.factValues_.get(label);
    value?.previousElementSibling?.remove();
    value?.remove();
    this.factValues_.delete(label);
  }

  private fact(label: string, text: string): HTMLElement {
    let value = this.factValues_.get(label);
    if (value === undefined) {
      value = el('dd');
      this.factValues_.set(label, value);
      this.facts_.append(el('dt', {}, label), value);
    }
    setText(value, text);
    return value;
  }
}
