// The settings panel, built from the server's table. What the page itself rules (field of view, picture size) stands
// among the rest.

import { FIELD_OF_VIEW_HIGH, FIELD_OF_VIEW_LOW } from '../../camera/camera.js';
import { el, icon, iconButton, setText } from '../../page/dom.js';
import { withoutUse } from './hybrid_rows.js';
import type { Panel } from '../panel.js';
import type { SettingRow, SettingValue } from '../../wire/protocol.js';
import { RESOLUTION_MODES, sizeText, type ResolutionMode } from '../../picture/resolution.js';
import { matches, presetOf, presetValues } from './presets.js';
import { SettingField } from './settings_field.js';
import { SettingsTools } from './settings_tools.js';
import { showField, viewerField, type OtherPanel } from './viewer_field.js';
import { recall, remember } from '../../page/storage.js';
import type { Viewer } from '../../viewer.js';
import './settings_panel.css';

/** Titles of the groups of rows that the server names, in their order. */
const TITLES: Readonly<Record<string, string>> = {
  picture: 'Picture',
  renderer: 'Renderer',
  hybrid: 'Hybrid',
};

/** Folded until the viewer opens them. */
const FOLDED_GROUPS: readonly string[] = ['renderer', 'hybrid'];

const FIELD_OF_VIEW_ROW: SettingRow = {
  name: 'fieldOfView',
  group: 'picture',
  acts: 'command',
  type: 'float',
  default: 60,
  low: FIELD_OF_VIEW_LOW,
  high: FIELD_OF_VIEW_HIGH,
  unit: 'deg',
  label: 'Field of view',
  effect: '',
  price: '',
  help: 'Vertical opening angle of the camera. Keys T and G change it too.',
  choices: [],
};

const DEFAULT_RESOLUTION: ResolutionMode = 'capped';

export class SettingsPanel {
  private readonly fields_ = new Map<string, SettingField>();
  private readonly tools_: SettingsTools;
  private fieldOfView_: SettingField | null = null;
  private fieldOfViewRow_ = FIELD_OF_VIEW_ROW;
  private resolution_ = el('span', { class: 'resolution' });
  private sizes_: HTMLSelectElement | null = null;
  private reset_: HTMLButtonElement | null = null;
  private undo_: HTMLButtonElement | null = null;

  constructor(
    private readonly panel_: Panel,
    private readonly viewer_: Viewer,
    private readonly others_: readonly OtherPanel[],
  ) {
    const start = (row: SettingRow): SettingValue => viewer_.settings.default(row);
    this.tools_ = new SettingsTools(
      (preset) => viewer_.setSettings(presetValues(preset, viewer_.settings.rows, start)),
      () => this.filter(),
    );
    panel_.body.append(el('p', { class: 'muted' }, 'The settings appear when the server answers.'));
    viewer_.on(['hello'], () => this.build());
    viewer_.on(['settings'], () => this.refresh());
    viewer_.on(['camera'], () => this.refreshCamera());
    viewer_.on(['resolution'], () => this.refreshResolution());
    viewer_.on(['watching'], () => this.refreshDriver());
  }

  private build(): void {
    const schema = this.viewer_.state.hello?.schema ?? [];
    const rows = this.viewer_.settings.rows.filter((row) => this.panelOf(row) === undefined);
    this.fields_.clear();
    this.fieldOfViewRow_ = { ...FIELD_OF_VIEW_ROW, ...schema.find((row) => row.name === FIELD_OF_VIEW_ROW.name) };
    const own: Readonly<Record<string, () => readonly HTMLElement[]>> = {
      picture: () => [this.cameraField(), this.resolutionField()],
    };
    const groups = [...new Set([...Object.keys(TITLES), ...rows.map((row) => row.group)])].map((name) => ({
      name,
      fields: [
        ...(own[name]?.() ?? []),
        ...rows.filter((row) => row.group === name).map((row) => this.field(row).element),
      ],
    }));
    this.panel_.body.replaceChildren(
      this.tools_.element,
      ...groups
        .filter(({ fields }) => fields.length > 0)
        .map(({ name, fields }) => this.group(name, TITLES[name] ?? name, fields)),
      el('div', { class: 'row-of-buttons' }, this.undoButton(), this.resetButton()),
    );
    this.refresh();
    this.refreshCamera();
    this.refreshResolution();
    this.refreshDriver();
  }

  private group(name: string, title: string, fields: readonly HTMLElement[]): HTMLElement {
    const key = `group.${name}`;
    const stored = recall(key);
    const open = stored === null ? !FOLDED_GROUPS.includes(name) : stored === 'open';
    const details = el(
      'details',
      { open },
      el('summary', {}, el('span', {}, title), icon('chevron')),
      el('div', { class: 'fields' }, ...fields),
    );
    details.addEventListener('toggle', () => {
      if (!details.classList.contains('searched')) remember(key, details.open ? 'open' : 'folded');
    });
    return details;
  }

  private field(row: SettingRow): SettingField {
    const field = viewerField(this.viewer_, row, () => this.refresh());
    this.fields_.set(row.name, field);
    return field;
  }

  /** The other panel in which the row stands. */
  private panelOf(row: SettingRow): OtherPanel | undefined {
    return this.others_.find((panel) => panel.has(row));
  }

  private cameraField(): HTMLElement {
    const row = this.fieldOfViewRow_;
    const field: SettingField = new SettingField(row, {
      changed: (value) => {
        const allowed = typeof value === 'number' && value >= row.low && value <= row.high;
        field.setError(allowed ? null : `fieldOfView: ${String(value)}, allowed: ${row.low} to ${row.high}`);
        if (allowed) this.viewer_.controller.setFieldOfView(value, performance.now());
        else this.refreshCamera();
      },
      invalid: (message) => field.setError(message),
      preset: () => this.presetFieldOfView(),
    });
    this.fieldOfView_ = field;
    return field.element;
  }

  private resolutionField(): HTMLElement {
    const options = RESOLUTION_MODES.map(({ mode, label }) => el('option', { value: mode }, label));
    const select = el('select', { id: 'resolution-mode' }, ...options);
    this.sizes_ = select;
    select.value = this.viewer_.state.resolutionMode;
    select.addEventListener('change', () => {
      const chosen = RESOLUTION_MODES.find(({ mode }) => mode === select.value);
      if (chosen === undefined) return;
      remember('resolution', chosen.mode);
      this.viewer_.setResolutionMode(chosen.mode);
    });
    const label = el('label', { for: 'resolution-mode' }, 'Picture size');
    const head = el('div', { class: 'field-head' }, label, el('span', { class: 'spacer' }), this.resolution_);
    return el('div', { class: 'field', 'data-setting': 'resolution' }, head, select);
  }

  private resetButton(): HTMLElement {
    const button = el('button', { type: 'button', class: 'wide-button' }, icon('reset'), 'Reset to defaults');
    button.addEventListener('click', () => this.reset());
    this.reset_ = button;
    return button;
  }

  private undoButton(): HTMLElement {
    const button = iconButton('undo', 'Undo', 'Ctrl Z', 'wide-button');
    button.addEventListener('click', () => this.viewer_.undoSettings());
    this.undo_ = button;
    return button;
  }

  /** Settings, field of view and picture size. */
  private reset(): void {
    const viewer = this.viewer_;
    viewer.setSettings(viewer.settings.defaults());
    viewer.controller.setFieldOfView(this.presetFieldOfView(), performance.now());
    if (this.sizes_ === null || this.sizes_.value === DEFAULT_RESOLUTION) return;
    this.sizes_.value = DEFAULT_RESOLUTION;
    remember('resolution', DEFAULT_RESOLUTION);
    viewer.setResolutionMode(DEFAULT_RESOLUTION);
  }

  private refresh(): void {
    const model = this.viewer_.settings;
    if (this.undo_ !== null) this.undo_.setAttribute('aria-disabled', String(this.viewer_.undo.size === 0));
    for (const row of model.rows) {
      const field = this.fields_.get(row.name);
      if (field === undefined) continue;
      showField(this.viewer_, row, field);
      if (row.group === 'hybrid') this.refreshHybrid(row, field);
    }
    this.filter();
  }

  /** Leaves the rows that are searched for; groups without any go, and those with some are opened. */
  private filter(): void {
    const model = this.viewer_.settings;
    const { search, onlyDiffering } = this.tools_;
    const filters = search !== '' || onlyDiffering;
    const differing = model.rows.filter((row) => !model.isDefault(row));
    const fits = (row: SettingRow): boolean => matches(row, search) && (!onlyDiffering || differing.includes(row));
    for (const row of model.rows) this.fields_.get(row.name)?.element.toggleAttribute('hidden', !fits(row));
    for (const own of this.panel_.body.querySelectorAll('[data-setting=fieldOfView], [data-setting=resolution]'))
      own.toggleAttribute('hidden', onlyDiffering || !(own.textContent ?? '').toLowerCase().includes(search.toLowerCase()));
    const elsewhere = filters ? model.rows.filter(fits).flatMap((row) => {
      const panel = this.panelOf(row);
      return panel === undefined ? [] : [[panel, row] as const];
    }) : [];
    this.tools_.showElsewhere(elsewhere);
    const shown = this.panel_.body.querySelectorAll('.field:not([hidden])').length + elsewhere.length;
    for (const group of this.panel_.body.querySelectorAll('details')) {
      group.hidden = group.querySelector('.field:not([hidden])') === null;
      group.classList.toggle('searched', filters); // what a search opens is not remembered
      if (filters && !group.open) group.dataset['folded'] = '';
      if (filters) group.open = true;
      else if ('folded' in group.dataset) {
        delete group.dataset['folded'];
        group.open = false;
      }
    }
    const start = (row: SettingRow): SettingValue => model.default(row);
    const preset = presetOf(model.rows, start, (name) => model.value(name));
    this.tools_.show(preset, differing.length, shown, this.viewer_.watching.active);
  }

  private refreshHybrid(row: SettingRow, field: SettingField): void {
    const reason = withoutUse(row, (name) => this.viewer_.settings.value(name));
    field.setNote(reason);
    field.element.classList.toggle('idle', reason !== null);
    if (row.name === 'hybridShare' && reason !== null) field.setDisabled(true);
  }

  private refreshCamera(): void {
    const angle = this.viewer_.controller.camera.fieldOfView;
    this.fieldOfView_?.show(Number(angle.toPrecision(3)), Math.abs(angle - this.presetFieldOfView()) < 0.05);
  }

  private presetFieldOfView(): number {
    return this.viewer_.state.ready?.camera.fieldOfView ?? 60;
  }

  private refreshResolution(): void {
    const { resolution, given } = this.viewer_.state;
    setText(this.resolution_, sizeText(resolution, given));
  }

  /** Who watches another viewer's view has nothing to choose but the JPEG quality. */
  private refreshDriver(): void {
    const watched = this.viewer_.watching.active;
    this.fieldOfView_?.setDisabled(watched);
    for (const button of [this.sizes_, this.reset_]) if (button !== null) button.disabled = watched;
    this.refresh();
  }
}

/** The mode that was chosen last time in this browser. */
export function storedResolutionMode(): ResolutionMode {
  return RESOLUTION_MODES.find(({ mode }) => mode === recall('resolution'))?.mode ?? DEFAULT_RESOLUTION;
}
