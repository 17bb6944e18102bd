// Puts the page together.

import './page/page.css'; // before what the parts bring
import { Banner } from './page/banner.js';
import { exposeDiagnostics } from './page/diagnostics.js';
import { DisplayError } from './picture/display.js';
import { el, iconButton, setText } from './page/dom.js';
import { whenFirstOpened } from './panels/lazy_panel.js';
import { isEffectRow } from './panels/effects/effect_rows.js';
import { EffectsPanel } from './panels/effects/effects_panel.js';
import { attachFocus } from './page/focus.js';
import { HelpDialog } from './page/help.js';
import { attachKeyboard, attachPointers } from './camera/input.js';
import { isLightRow } from './panels/light/light_rows.js';
import { LightPanel } from './panels/light/light_panel.js';
import { KEY_TURN, LightTurn } from './panels/light/light_turn.js';
import { attachGamepads, MouseLock, thumbStick } from './camera/steering.js';
import { Panel } from './panels/panel.js';
import { PickView } from './panels/pick/pick_view.js';
import { ErrorView, toggleErrors } from './panels/errors/error_view.js';
import { PartitionView, togglePartition } from './panels/partition/partition_view.js';
import { MIME_TYPES, type Frame } from './wire/frame.js';
import { knowDevices } from './panels/device_colors.js';
import { displayName, fileName } from './page/scene_name.js';
import { SettingsPanel, storedResolutionMode } from './panels/settings/settings_panel.js';
import { StatsPanel } from './panels/statistics/stats_panel.js';
import { copyPicture } from './page/copy_picture.js';
import { recall, remember } from './page/storage.js';
import { Toasts } from './page/toast.js';
import { Dock, SceneBar, type DockHooks, type Panels, type SceneBarHooks } from './page/toolbar.js';
import { traceFile } from './picture/frame_trace.js';
import { UploadView } from './upload/upload_view.js';
import { Viewer } from './viewer.js';
import { Compare } from './views/compare.js';
import { ViewShelf } from './views/view_shelf.js';
import { copyText, ViewLink } from './page/view_link.js';
import './panels/accuracy/accuracy_panel.css'; // a panel that is loaded later brings none
import './page/access.css'; // after what it says otherwise

/** One below the other. */
const COLUMN = ['light', 'settings', 'effects', 'accuracy'] as const;

const EXTENSIONS = { png: 'png', exr: 'exr', jpeg: 'jpg', vp9: 'vp9', h264: 'h264' } as const;

function download(file: Blob, name: string): void {
  const url = URL.createObjectURL(file);
  el('a', { href: url, download: name }).click();
  window.setTimeout(() => URL.revokeObjectURL(url), 10_000);
}

function saveToDisk(frame: Frame, scene: string): string {
  const name = fileName(scene, frame.width, frame.height, frame.samples, EXTENSIONS[frame.codec]);
  download(new Blob([frame.payload], { type: MIME_TYPES[frame.codec] }), name);
  return name;
}

function saveTrace(viewer: Viewer): string {
  const name = `${viewer.state.readyName || 'heliograph'}-trace.json`;
  download(new Blob([traceFile(viewer.stream.trace.frames)], { type: 'application/json' }), name);
  return name;
}

/** Copies the address of the view; where the browser does not allow that it is shown. */
async function share(viewer: Viewer, toasts: Toasts): Promise<void> {
  const address = viewer.seat.shareAddress();
  if (address === null) return void toasts.show('error', 'There is no view to share yet. Wait until the server answers.');
  try {
    await navigator.clipboard.writeText(address);
    toasts.show('notice', 'The link is copied. Who opens it watches this view, and drives it when you leave or hand it over.');
  } catch {
    toasts.show('notice', `Who opens this link watches this view: ${address}`, true);
  }
}

async function copy(toasts: Toasts): Promise<void> {
  const shown = document.querySelector<HTMLCanvasElement>('body > canvas');
  const done = shown !== null && (await copyPicture(shown));
  if (done) toasts.show('notice', 'The picture is in the clipboard.');
  else toasts.show('error', 'The browser does not let this page copy pictures. Save it instead (F3).');
}

const sharing = (viewer: Viewer, toasts: Toasts): Pick<DockHooks, 'share' | 'saveTrace' | 'copyPicture'> => ({
  copyPicture: () => void copy(toasts),
  share: () => void share(viewer, toasts),
  saveTrace: () => void toasts.show('notice', `Saved ${saveTrace(viewer)}`),
});

/** For who sees the page for the first time in this browser; gone with the first key or press. */
function hint(toasts: Toasts): void {
  if (recall('hint') !== null) return;
  remember('hint', 'seen');
  const touch = window.matchMedia('(pointer: coarse)').matches;
  const toast = toasts.show(
    'notice',
    touch
      ? 'One finger looks around, two or the stick move. Viewpoint, Reset view leads back.'
      : 'Drag to look around, W A S D to move, R leads back, H lists all keys.',
  );
  for (const input of ['keydown', 'pointerdown']) window.addEventListener(input, () => toast.close(), { once: true });
}

/** Messages, pictures that arrive, and what a screen reader hears. */
function attachMessages(viewer: Viewer, toasts: Toasts, announce: (text: string) => void): void {
  viewer.onMessage = ({ kind, text }) => void toasts.show(kind, text);
  viewer.onPicture = (frame) => {
    toasts.show('notice', `Saved ${saveToDisk(frame, viewer.state.readyName)}`);
  };
  let playing = false;
  viewer.on(['path'], () => {
    if (viewer.state.pathPlaying && !playing) toasts.show('notice', 'The benchmark path plays. F2 or Stop ends it.');
    playing = viewer.state.pathPlaying;
  });
  let announced = '';
  viewer.on(['scene'], () => {
    const { scene, readyName, ready } = viewer.state;
    if (scene?.state !== 'ready' || ready === null || readyName === announced) return;
    announced = readyName;
    announce(`${displayName(readyName)} is shown.`);
    hint(toasts);
    const warnings = ready.warnings.length;
    const [first] = ready.warnings;
    if (first === undefined) return;
    toasts.show('notice', warnings === 1 ? first : `${first} (and ${warnings - 1} more: see About the scene)`);
  });
}

async function copyLink(link: string, toasts: Toasts): Promise<void> {
  const done = await copyText(link);
  toasts.show('notice', done ? 'The link to this view is in the clipboard.' : 'Copy the address of this page: it is the view.');
}

/** What leads to views: links, those that are saved, and the one to compare with. */
function sceneBarHooks(
  viewer: Viewer,
  link: ViewLink,
  canvas: HTMLCanvasElement,
  compare: Compare,
  toasts: Toasts,
  panels: Panels,
  ownFiles: () => void,
): SceneBarHooks {
  const shelf = new ViewShelf(viewer, canvas, () => link.link());
  return {
    copyLink: () => void copyLink(link.link(), toasts),
    views: () => shelf.items(),
    compare: () => compare.begin(),
    measure: () => panels.accuracy.setOpen(true),
    ownFiles,
  };
}

/** Control or Command with Z. */
function attachUndo(viewer: Viewer): void {
  window.addEventListener('keydown', (event) => {
    const typing = event.target instanceof HTMLInputElement && event.target.type === 'text';
    if (event.code !== 'KeyZ' || !(event.ctrlKey || event.metaKey) || event.shiftKey || typing) return;
    event.preventDefault();
    viewer.undoSettings();
  });
}

const makeLightTurn = (viewer: Viewer): LightTurn =>
  new LightTurn({
    rows: () => viewer.settings.rows,
    value: (name) => viewer.settings.value(name),
    set: (values) => viewer.setSettings(values),
    notice: (text) => viewer.onMessage({ kind: 'notice', text }),
  });

function attachPicture(canvas: HTMLCanvasElement, viewer: Viewer, light: LightTurn): void {
  attachPointers(canvas, viewer.controller, {
    pick: (x, y) => viewer.pickAt(x, y),
    turnLight: (dx) => light.drag(dx, canvas.getBoundingClientRect().height),
  });
  attachFocus(canvas);
  attachUndo(viewer);
}

/** The page's shortcuts, and the keys of flying. */
function attachKeys(
  viewer: Viewer,
  light: LightTurn,
  page: Readonly<Record<'help' | 'togglePanels' | 'toggleMode' | 'pick' | 'mouse', () => void>>,
): void {
  attachKeyboard(viewer.controller, {
    F1: page.togglePanels,
    F2: () => viewer.togglePath(),
    F3: () => viewer.savePicture('png'),
    KeyH: page.help,
    '?': page.help,
    KeyO: page.toggleMode,
    KeyR: () => viewer.resetView(),
    KeyV: () => viewer.frameAll(),
    KeyI: page.pick,
    KeyL: page.mouse,
    BracketLeft: () => light.by(-KEY_TURN),
    BracketRight: () => light.by(KEY_TURN),
    KeyP: () => togglePartition(viewer),
    KeyN: () => toggleErrors(viewer),
  });
  attachGamepads(viewer.controller, {
    0: page.pick,
    1: page.toggleMode,
    2: () => viewer.frameAll(),
    3: () => viewer.resetView(),
  });
}

function makePanels(viewer: Viewer): Panels {
  const group: Panel[] = [];
  const roomy = window.matchMedia('(min-width: 1281px) and (min-height: 721px)').matches; // else too little picture is left
  const statistics = new Panel('statistics', 'Statistics', group, roomy);
  const light = new Panel('light', 'Light', group, false);
  const settings = new Panel('settings', 'Settings', group);
  const effects = new Panel('effects', 'Effects', group, false);
  const accuracy = new Panel('accuracy', 'Accuracy', group, false);
  new StatsPanel(statistics, viewer);
  const lights = new LightPanel(light, viewer);
  const inLight = { title: 'Light', has: isLightRow, open: (name: string) => lights.open(name) };
  const list = new EffectsPanel(effects, viewer, inLight);
  const inEffects = { title: 'Effects', has: isEffectRow, open: (name: string) => list.open(name) };
  new SettingsPanel(settings, viewer, [inLight, inEffects]);
  whenFirstOpened(accuracy, async () => {
    const { AccuracyPanel } = await import('./panels/accuracy/accuracy_panel.js');
    return () => void new AccuracyPanel(accuracy, viewer);
  });
  return { statistics, light, settings, effects, accuracy };
}

function start(): void {
  const canvas = document.querySelector('canvas')!;
  const page = document.querySelector<HTMLElement>('#page')!;
  const viewer = new Viewer(canvas, storedResolutionMode());
  viewer.on(['hello'], () => knowDevices(viewer.state.hello?.devices ?? []));
  exposeDiagnostics(viewer);

  const link = new ViewLink(viewer);
  const toasts = new Toasts();
  const live = el('div', { class: 'sr-only', role: 'status', 'aria-live': 'polite' });
  const announce = (text: string): void => setText(live, text);
  attachMessages(viewer, toasts, announce);

  const panels = makePanels(viewer);
  const help = new HelpDialog();
  const restore = iconButton('show', 'Show panels', 'F1', 'restore');
  const togglePanels = (): void => {
    page.classList.toggle('bare');
    if (document.activeElement instanceof HTMLElement) document.activeElement.blur();
  };
  restore.addEventListener('click', togglePanels);
  const hooks = { help: () => help.toggle(), hide: togglePanels, ...sharing(viewer, toasts) };
  const dock = new Dock(viewer, panels, hooks);
  const banner = new Banner(viewer, announce);
  const partition = new PartitionView(viewer, announce);
  const errors = new ErrorView(viewer, announce);
  const compare = new Compare(canvas);
  const upload = new UploadView(viewer, announce);
  const pick = new PickView(viewer, announce, () => canvas.focus({ preventScroll: true }));
  page.append(
    ...[partition.overlay, errors.overlay],
    thumbStick(viewer.controller),
    compare.element,
    partition.card,
    errors.card,
    pick.marks,
    pick.card,
    new SceneBar(viewer, sceneBarHooks(viewer, link, canvas, compare, toasts, panels, () => upload.choose())).element,
    dock.element, // before the panels, whose many fields would stand between it and the picture
    panels.statistics.element,
    el('div', { class: 'column' }, ...COLUMN.map((name) => panels[name].element)),
    restore,
    banner.element,
    toasts.element,
    upload.element,
    live,
    help.element,
  );

  const light = makeLightTurn(viewer);
  attachPicture(canvas, viewer, light);
  const mouse = new MouseLock(canvas, viewer.controller, (text) => viewer.onMessage({ kind: 'notice', text }));
  attachKeys(viewer, light, {
    ...{ help: hooks.help, togglePanels, toggleMode: () => dock.toggleMode() },
    ...{ pick: () => pick.pickMiddle(), mouse: () => mouse.toggle() },
  });
  viewer.connect();
}

try {
  start();
} catch (error) {
  const text = error instanceof DisplayError ? error.message : `The page could not start: ${String(error)}`;
  document.body.append(el('p', { class: 'fatal', role: 'alert' }, text));
  throw error;
}
