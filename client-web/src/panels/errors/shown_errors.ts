// Which map of the error lies over the picture at the moment: the one that came with it, while it is wanted.

import type { Frame } from '../../wire/frame.js';
import type { ErrorMap } from '../../wire/errors_message.js';
import { PartitionStore } from '../partition/partition.js';

export interface ShownMap {
  readonly map: ErrorMap;
  readonly frame: Pick<Frame, 'frameId' | 'width' | 'height'>; // the picture it belongs to
}

export class ShownErrors {
  private readonly waiting_ = new PartitionStore<ErrorMap>();
  private shown_: ShownMap | null = null;

  /** `changed` is called when another one or none is shown. */
  constructor(
    private readonly wanted_: () => boolean,
    private readonly changed_: () => void,
  ) {}

  /** Null: nothing is to be shown. */
  get shown(): ShownMap | null {
    return this.shown_;
  }

  received(map: ErrorMap): void {
    this.waiting_.put(map);
  }

  /** A picture is put on the canvas. */
  drawn(frame: ShownMap['frame']): void {
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

  private show(shown: ShownMap | null): void {
    if (shown === null && this.shown_ === null) return;
    this.shown_ = shown;
    this.changed_();
  }
}
