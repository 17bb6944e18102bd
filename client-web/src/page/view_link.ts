// Keeps the page's address at the view that is shown, and the view at the address: when the page opens, and when the
// viewer goes back and forward. A flight or a setting changes the present entry of the history; a jump makes a new one.

import type { Viewer } from '../viewer.js';
import { changedSettings, fragmentOf, settingValues, viewOfFragment, type AddressedView } from './view_address.js';
import { tokenOf } from '../wire/token.js';

const WRITE_AFTER = 400; // ms without a change; browsers allow some 100 changes of the address in 30 s

export class ViewLink {
  private timer_ = 0;
  private jumped_ = false; // the next change of the address is a new entry
  private opening_: AddressedView | null;

  constructor(private readonly viewer_: Viewer) {
    const view = viewOfFragment(location.hash);
    this.opening_ = viewer_.watching.view === null ? view : null;
    if (this.opening_ !== null && view.scene !== '') viewer_.lookAt(view.scene, view.camera);
    viewer_.on(['hello'], () => this.greeted());
    viewer_.on(['scene'], () => this.sceneChanged());
    viewer_.on(['camera', 'settings', 'scene', 'path'], () => this.soon());
    viewer_.on(['jump'], () => {
      this.write();
      this.jumped_ = true;
    });
    window.addEventListener('popstate', () => this.wentTo());
  }

  /** The address that shows this view to anybody at this server. */
  link(): string {
    const url = new URL(location.href);
    url.hash = fragmentOf({ ...this.present(), scene: this.viewer_.state.readyName });
    return url.href;
  }

  private greeted(): void {
    const { settings } = this.viewer_;
    const values = settingValues(settings.rows, this.opening_?.settings ?? {});
    if (Object.keys(values).length > 0) this.viewer_.setSettings(values);
  }

  private sceneChanged(): void {
    const { scene, ready, readyName } = this.viewer_.state;
    const opening = this.opening_;
    if (opening === null || scene?.state !== 'ready' || ready === null) return;
    this.opening_ = null;
    if (opening.scene === '' || opening.scene === readyName) return;
    this.viewer_.onMessage({ kind: 'notice', text: `The scene ${opening.scene} of this address is not offered here.` });
  }

  private soon(): void {
    window.clearTimeout(this.timer_);
    this.timer_ = window.setTimeout(() => this.write(), WRITE_AFTER);
  }

  private present(): AddressedView {
    const { settings, controller, state } = this.viewer_;
    const own = state.ready === null || fragmentOf(camera(state.ready.camera)) === fragmentOf(camera(controller.camera));
    return {
      scene: own && state.readyName === state.ownScene ? '' : state.readyName,
      camera: own ? null : controller.camera,
      settings: changedSettings(
        settings.rows,
        (row) => settings.value(row.name),
        (row) => settings.isDefault(row),
      ),
    };
  }

  private write(): void {
    window.clearTimeout(this.timer_);
    const { ready, scene, pathPlaying } = this.viewer_.state;
    if (this.viewer_.watching.active || ready === null || scene?.state !== 'ready' || pathPlaying) return;
    if (tokenOf(location.href) !== null) return;
    const fragment = fragmentOf(this.present());
    const url = new URL(location.href);
    if (url.hash.slice(1) === fragment) return;
    url.hash = fragment;
    if (this.jumped_) history.pushState(null, '', url.href);
    else history.replaceState(null, '', url.href);
    this.jumped_ = false;
  }

  private wentTo(): void {
    const viewer = this.viewer_;
    if (tokenOf(location.href) !== null || viewer.watching.active || viewer.state.ready === null) return;
    window.clearTimeout(this.timer_);
    this.jumped_ = false;
    const view = viewOfFragment(location.hash);
    const { settings, state } = viewer;
    const wanted = { ...settings.defaults(), ...settingValues(settings.rows, view.settings) };
    const changed = Object.entries(wanted).filter(([name, value]) => settings.value(name) !== value);
    if (changed.length > 0) viewer.setSettings(Object.fromEntries(changed));
    viewer.lookAt(view.scene === '' ? state.ownScene : view.scene, view.camera);
  }
}

const camera = (value: AddressedView['camera']): AddressedView => ({ scene: '', camera: value, settings: {} });

/** False where the browser lets nobody write to its clipboard. */
export async function copyText(text: string): Promise<boolean> {
  try {
    await navigator.clipboard.writeText(text);
    return true;
  } catch {
    return copyBySelection(text); // a page by http:// of another machine has no clipboard
  }
}

function copyBySelection(text: string): boolean {
  const field = document.createElement('textarea');
  const { activeElement } = document;
  field.value = text;
  field.className = 'sr-only';
  document.body.append(field);
  field.select();
  const done = document.execCommand('copy');
  field.remove();
  if (activeElement instanceof HTMLElement) activeElement.focus({ preventScroll: true });
  return done;
}
