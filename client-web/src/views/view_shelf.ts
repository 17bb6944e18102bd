// Saves views with small pictures, and goes to them.

import type { MenuItem } from '../page/menu.js';
import { displayName } from '../page/scene_name.js';
import { recall, remember } from '../page/storage.js';
import type { Viewer } from '../viewer.js';
import { nameFor, savedViews, withSaved } from './saved_views.js';

const KEY = 'views';
const PICTURE = { width: 96, height: 54 }; // pixels

export class ViewShelf {
  /** `link`: the address that shows the present view. */
  constructor(
    private readonly viewer_: Viewer,
    private readonly picture_: HTMLCanvasElement,
    private readonly link_: () => string,
  ) {}

  items(): readonly MenuItem[] {
    const views = savedViews(recall(KEY));
    const save = { label: 'Save this view', description: 'Scene, place and settings, kept in this browser' };
    const forget = { label: 'Forget saved views', choose: () => remember(KEY, '[]') };
    const saved = views.map(({ name, fragment, picture }) => ({
      label: name,
      ...(picture === '' ? {} : { picture }),
      choose: () => this.goTo(fragment),
    }));
    return [{ ...save, choose: () => this.save() }, ...saved, ...(views.length === 0 ? [] : [forget])];
  }

  private save(): void {
    const { readyName, ready } = this.viewer_.state;
    if (ready === null) return;
    const views = savedViews(recall(KEY));
    const fragment = new URL(this.link_()).hash.slice(1);
    const name = nameFor(displayName(readyName), views);
    remember(KEY, JSON.stringify(withSaved(views, { name, fragment, picture: this.small() })));
    this.viewer_.onMessage({ kind: 'notice', text: `Saved as ${name}, under Viewpoint.` });
  }

  /** The address is the view: the page goes there as it would by Back. */
  private goTo(fragment: string): void {
    if (this.viewer_.seat.drivenByOthers()) return;
    location.hash = fragment;
  }

  private small(): string {
    const copy = document.createElement('canvas');
    [copy.width, copy.height] = [PICTURE.width, PICTURE.height];
    const { width, height } = this.picture_;
    const scale = Math.max(PICTURE.width / width, PICTURE.height / height);
    const [w, h] = [width * scale, height * scale];
    copy.getContext('2d')?.drawImage(this.picture_, (PICTURE.width - w) / 2, (PICTURE.height - h) / 2, w, h);
    return copy.toDataURL('image/jpeg', 0.7);
  }
}
