// The two bars over the picture: scene and viewpoint at the top, actions in the dock at the bottom.

import { el, icon, iconButton, setText, uniqueId, type IconName } from './dom.js';
import { count, whole } from './format.js';
import { LookMenu } from './look_menu.js';
import { sceneOfLook } from './look_name.js';
import { LimitBadge } from './limit_badge.js';
import { Menu, type MenuItem } from './menu.js';
import type { Panel } from '../panels/panel.js';
import { fullScreenButton } from './full_screen.js';
import { displayName, pageTitle, spacedWords } from './scene_name.js';
import { ScenePictures } from './scene_pictures.js';
import type { Viewer } from '../viewer.js';
import './toolbar.css';

export interface SceneBarHooks {
  /** The address of this view to the clipboard. */
  readonly copyLink: () => void;
  /** To save views and to go to them. */
  readonly views: () => readonly MenuItem[];
  /** Asks for files of the viewer's own. */
  readonly ownFiles: () => void;
  /** Freezes the picture to compare with what comes. */
  readonly compare: () => void;
  /** Opens the panel that measures the view. */
  readonly measure: () => void;
}

export type Panels = Readonly<Record<'statistics' | 'light' | 'settings' | 'effects' | 'accuracy', Panel>>;

/** Scene, viewpoint and what there is to know of the scene. */
export class SceneBar {
  readonly element: HTMLElement;
  private readonly sceneLabel_ = el('span', { class: 'picker-label' }, '…');
  private readonly info_: InfoPopover;
  private readonly pictures_ = new ScenePictures();

  constructor(
    private readonly viewer_: Viewer,
    private readonly hooks_: SceneBarHooks,
  ) {
    const sceneButton = el(
      'button',
      { type: 'button', class: 'picker', title: 'Choose a scene' },
      el('span', { class: 'sr-only' }, 'Scene: '),
      this.sceneLabel_,
      icon('chevron'),
    );
    const cameraButton = iconButton('camera', 'Viewpoint', 'R resets', 'tool');
    const scenes = new Menu(sceneButton, 'Scenes', () => this.sceneItems());
    scenes.element.classList.add('grow');
    const cameras = new Menu(cameraButton, 'Viewpoints', () => this.cameraItems());
    this.info_ = new InfoPopover(viewer_);
    const brand = el('span', { class: 'brand' }, icon('sun'), el('span', { class: 'brand-name' }, 'Heliograph'));
    const link = iconButton('link', 'Copy link', '', 'tool icon-only');
    link.addEventListener('click', hooks_.copyLink);
    const frame = iconButton('frame', 'Frame all', 'V', 'tool icon-only');
    frame.addEventListener('click', () => viewer_.frameAll());
    const views = [cameras.element, frame, fullScreenButton(), link];
    const looks = new LookMenu(viewer_).element;
    const parts = [brand, scenes.element, looks, ...views, this.info_.element, new LimitBadge(viewer_).element];
    this.element = el('header', { class: 'bar top-bar' }, ...parts);
    viewer_.on(['scene', 'hello'], () => this.refresh());
    viewer_.on(['frame'], () => this.title());
    viewer_.on(['hello'], () => this.pictures_.forget());
  }

  private refresh(): void {
    const { scene, readyName } = this.viewer_.state;
    const name = scene === null || scene.state === 'failed' ? readyName : scene.name;
    setText(this.sceneLabel_, name === '' ? '…' : displayName(name));
    this.title();
  }

  /** Says so when the picture is done, for who works in another tab meanwhile. */
  private title(): void {
    const { scene, readyName, lastFrame } = this.viewer_.state;
    const name = scene === null || scene.state === 'failed' ? readyName : scene.name;
    const title = pageTitle(name, scene?.state === 'ready' && lastFrame?.final === true);
    if (document.title !== title) document.title = title;
  }

  private sceneItems(): readonly MenuItem[] {
    const { hello, scene, readyName } = this.viewer_.state;
    const offered = (hello?.scenes ?? []).map((entry) => entry.name);
    const present = sceneOfLook(scene?.state === 'loading' ? scene.name : readyName, offered);
    const items = (hello?.scenes ?? []).map((entry) => ({
      label: displayName(entry.name),
      description: entry.description,
      checked: entry.name === present,
      picture: (image: HTMLImageElement) => this.pictures_.show(image, entry.name),
      choose: () => this.viewer_.openScene(entry.name),
    }));
    const own = { label: 'Own files …', description: 'Or drop a model, its folder, or an HDR on the page' };
    return [...items, { ...own, choose: this.hooks_.ownFiles }];
  }

  private cameraItems(): readonly MenuItem[] {
    const cameras = this.viewer_.state.ready?.cameras ?? [];
    const named = cameras.map((camera) => ({
      label: displayName(camera.name),
      choose: () => this.viewer_.jumpTo(camera),
    }));
    const path = { label: 'Play the path', description: 'A benchmark: along the scene’s own way, as F2' };
    const compare = { label: 'Compare', description: 'Freezes this picture, to wipe between it and what comes' };
    const measure = { label: 'Accuracy', description: 'Measures what each setting costs here, and what it buys' };
    return [
      { label: 'Reset view', hint: 'R', choose: () => this.viewer_.resetView() },
      ...named,
      ...this.hooks_.views(),
      ...((this.viewer_.state.ready?.paths.length ?? 0) > 0 ? [{ ...path, choose: () => this.viewer_.togglePath() }] : []),
      { ...compare, choose: this.hooks_.compare },
      { ...measure, choose: this.hooks_.measure },
    ];
  }
}

/** Size, lights and warnings of the scene, behind a button that counts the warnings. */
class InfoPopover {
  readonly element: HTMLElement;
  private readonly button_ = iconButton('info', 'About the scene', '', 'tool icon-only');
  private readonly badge_ = el('span', { class: 'badge', hidden: true });
  private readonly card_: HTMLElement;

  constructor(private readonly viewer_: Viewer) {
    const id = uniqueId('info');
    this.card_ = el('div', {
      class: 'menu info-card',
      id,
      role: 'region',
      'aria-label': 'About the scene',
      tabindex: -1,
      hidden: true,
    });
    this.button_.setAttribute('aria-controls', id);
    this.button_.setAttribute('aria-expanded', 'false');
    this.button_.append(this.badge_);
    this.element = el('div', { class: 'menu-anchor' }, this.button_, this.card_);
    this.button_.addEventListener('click', () => this.show(this.card_.hidden));
    this.element.addEventListener('keydown', (event) => {
      if (event.code !== 'Escape' || this.card_.hidden) return;
      this.show(false);
      this.button_.focus();
    });
    document.addEventListener('pointerdown', (event) => {
      if (event.target instanceof Node && !this.element.contains(event.target)) this.show(false);
    });
    viewer_.on(['scene'], () => this.refresh());
  }

  private show(open: boolean): void {
    this.card_.hidden = !open;
    this.button_.setAttribute('aria-expanded', String(open));
    if (open) this.card_.focus();
  }

  private refresh(): void {
    const { ready, readyName, hello } = this.viewer_.state;
    if (ready === null) return;
    const warnings = ready.warnings.length;
    setText(this.badge_, String(warnings));
    this.badge_.hidden = warnings === 0;
    this.button_.setAttribute(
      'aria-label',
      warnings === 0 ? 'About the scene' : `About the scene, ${warnings} warnings`,
    );
    const description = hello?.scenes.find((entry) => entry.name === readyName)?.description ?? '';
    const facts: readonly (readonly [string, string])[] = [
      ['Triangles', whole(ready.triangles)],
      ['Instances', count(ready.instances)],
      ['Lights', count(ready.lights)],
      [
        'Effects',
        ready.effects
          .filter((effect) => effect.calledFor && effect.simulated)
          .map((effect) => spacedWords(effect.name))
          .join(', ') || 'none',
      ],
    ];
    const list = el('dl', { class: 'facts' });
    for (const [label, value] of facts) list.append(el('dt', {}, label), el('dd', {}, value));
    this.card_.replaceChildren(
      el('h3', {}, displayName(readyName)),
      description === '' ? '' : el('p', { class: 'muted' }, description),
      list,
    );
    if (warnings === 0) return;
    const items = ready.warnings.map((warning) => el('li', {}, warning));
    this.card_.append(
      el('h4', {}, icon('warning'), `${warnings} ${warnings === 1 ? 'warning' : 'warnings'}`),
      el('ul', {}, ...items),
    );
  }
}

export interface DockHooks {
  share(): void;
  saveTrace(): void;
  copyPicture(): void;
  help(): void;
  hide(): void;
}

/** Actions: navigation mode, path, save, panels, help. */
export class Dock {
  readonly element: HTMLElement;
  private readonly mode_ = iconButton('fly', 'Fly', 'O', 'tool');
  private readonly path_ = iconButton('play', 'Path', 'F2', 'tool path');
  private readonly save_ = iconButton('save', 'Save', 'F3', 'tool');

  constructor(
    private readonly viewer_: Viewer,
    panels: Panels,
    private readonly hooks_: DockHooks,
  ) {
    const help = iconButton('help', 'Help', 'H', 'tool');
    const hide = iconButton('hide', 'Hide', 'F1', 'tool');
    const save = new Menu(this.save_, 'Save the picture', () => this.saveItems());
    this.mode_.addEventListener('click', () => this.toggleMode());
    this.path_.addEventListener('click', () => viewer_.togglePath());
    help.addEventListener('click', () => hooks_.help());
    hide.addEventListener('click', () => hooks_.hide());
    const separator = (): HTMLElement => el('span', { class: 'separator', 'aria-hidden': 'true' });
    this.element = el(
      'nav',
      { class: 'bar dock', 'aria-label': 'Actions' },
      this.mode_,
      this.path_,
      save.element,
      separator(),
      this.panelButton('chart', 'Stats', panels.statistics),
      this.panelButton('bulb', 'Light', panels.light),
      this.panelButton('sliders', 'Settings', panels.settings),
      this.panelButton('sparkle', 'Effects', panels.effects),
      this.panelButton('scatter', 'Accuracy', panels.accuracy, 'accuracy'),
      separator(),
      help,
      hide,
    );
    viewer_.on(['camera'], () => this.refreshMode());
    viewer_.on(['path', 'frame'], () => this.refreshActions());
    this.refreshMode();
    this.refreshActions();
  }

  toggleMode(): void {
    this.viewer_.controller.setMode(this.viewer_.controller.mode === 'fly' ? 'orbit' : 'fly');
  }

  private panelButton(name: IconName, label: string, panel: Panel, kind = ''): HTMLButtonElement {
    const button = iconButton(name, label, '', `tool ${kind}`.trim());
    button.addEventListener('click', () => panel.setOpen(!panel.isOpen));
    panel.onToggle((open) => button.setAttribute('aria-pressed', String(open)));
    return button;
  }

  private saveItems(): readonly MenuItem[] {
    const save = (format: 'png' | 'exr' | 'jpg') => () => this.viewer_.savePicture(format);
    return [
      { label: 'PNG', description: 'The picture as shown, at full resolution', hint: 'F3', choose: save('png') },
      { label: 'EXR', description: 'The film as floats, linear, before exposure and tone curve', choose: save('exr') },
      { label: 'JPEG', description: 'The picture as shown, small', choose: save('jpg') },
      { label: 'Copy', description: 'The picture as shown here, into the clipboard', choose: () => this.hooks_.copyPicture() },
      { label: 'Link to this view', description: 'Who opens it watches what you see', choose: () => this.hooks_.share() },
      {
        label: 'Trace',
        description: 'Where the time of the last 600 frames went, for chrome://tracing or Perfetto',
        choose: () => this.hooks_.saveTrace(),
      },
    ];
  }

  private refreshMode(): void {
    const orbit = this.viewer_.controller.mode === 'orbit';
    const label = this.mode_.querySelector('.label')!;
    if (label.textContent === (orbit ? 'Orbit' : 'Fly') && this.mode_.dataset['ready'] === 'true') return;
    this.mode_.dataset['ready'] = 'true';
    label.textContent = orbit ? 'Orbit' : 'Fly';
    this.mode_.title = orbit
      ? 'Dragging turns around the scene. Switch to flying (O)'
      : 'Dragging looks around. Switch to orbiting (O)';
    this.mode_.setAttribute('aria-label', orbit ? 'Navigation: orbit' : 'Navigation: fly');
    this.mode_.querySelector('svg')!.replaceWith(icon(orbit ? 'orbit' : 'fly'));
  }

  private refreshActions(): void {
    const { pathPlaying, picturesAwaited } = this.viewer_.state;
    const label = this.path_.querySelector('.label')!;
    const text = pathPlaying ? 'Stop' : 'Path';
    if (label.textContent !== text || this.path_.getAttribute('aria-pressed') === null) {
      label.textContent = text;
      this.path_.setAttribute('aria-pressed', String(pathPlaying));
      this.path_.setAttribute('aria-label', pathPlaying ? 'Stop the benchmark path' : 'Play the benchmark path');
      this.path_.title = `${pathPlaying ? 'Stop' : 'Play'} the benchmark path (F2)`;
      this.path_.querySelector('svg')!.replaceWith(icon(pathPlaying ? 'stop' : 'play'));
    }
    this.save_.classList.toggle('busy', picturesAwaited > 0);
  }
}
