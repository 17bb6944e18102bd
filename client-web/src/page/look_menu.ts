// The looks that a scene's file offers for its surfaces, as a menu beside the scene; hidden where there are none.

import { iconButton } from './dom.js';
import { lookName, sceneOfLook } from './look_name.js';
import { Menu, type MenuItem } from './menu.js';
import type { Viewer } from '../viewer.js';

export class LookMenu {
  readonly element: HTMLElement;

  constructor(private readonly viewer_: Viewer) {
    const button = iconButton('layers', 'Look', '', 'tool icon-only');
    this.element = new Menu(button, 'Looks of this scene', () => this.items()).element;
    this.element.hidden = true;
    viewer_.on(['scene'], () => {
      this.element.hidden = (viewer_.state.ready?.variants.length ?? 0) === 0;
    });
  }

  private items(): readonly MenuItem[] {
    const { ready, readyName, hello } = this.viewer_.state;
    if (ready === null) return [];
    const offered = (hello?.scenes ?? []).map((entry) => entry.name);
    const base = sceneOfLook(readyName, offered);
    const named = ready.variants.map((label, number) => ({
      label: label === '' ? `Look ${number}` : label,
      checked: ready.variant === number,
      choose: () => this.open(lookName(base, ready.variants, number)),
    }));
    const own = { label: "The file's own", checked: ready.variant === null };
    return [{ ...own, choose: () => this.open(base) }, ...named];
  }

  /** From where the scene is seen now. */
  private open(name: string): void {
    this.viewer_.openScene(name, this.viewer_.controller.camera);
  }
}
