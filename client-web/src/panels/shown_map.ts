// Which map lies over the picture at the moment, as who made it or where its error is: the one that came with it, while it is wanted.

import type { Frame } from '../wire/frame.js';
import { MapStore } from './map_store.js';

export interface Shown<T> {
  readonly map: T;
  readonly frame: Pick<Frame, 'frameId' | 'width' | 'height'>; // the picture it belongs to
}

export class ShownMap<T extends { readonly frameId: number }> {
  private readonly waiting_ = new MapStore<T>();
  private shown_: Shown<T> | null = null;

  /** `wanted`: whether the viewer wants to see such maps; `changed` is called when another one or none is shown. */
  constructor(
    private readonly wanted_: () => boolean,
    private readonly changed_: () => void,
  ) {}

  /** Null: nothing is to be shown. */
  get shown(): Shown<T> | null {
    return this.shown_;
  }

  received(map: T): void {
    this.waiting_.put(map);
  }

  /** A picture is put on the canvas. */
  drawn(frame: Shown<T>['frame']): void {
    const map = this.waiting_.take(frame.frameId);
    this.show(map === null || !this.wanted_() ? null : { map, frame });
  }

  /** What the viewer asks for may have changed. */
  settingsChanged(): void {
    if (!this.wanted_()) this.show(null);
  }

  /** Another scene or another connection: nothing that is known belongs to the next picture. */
  forget(): void {
    this.waiting_.clear();
    this.show(null);
  }

  private show(shown: Shown<T> | null): void {
    if (shown === null && this.shown_ === null) return;
    this.shown_ = shown;
    this.changed_();
  }
}
