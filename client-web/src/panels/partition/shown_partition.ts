// Which partition lies over the picture at the moment: the one that came with it, while it is wanted.

import type { Frame } from '../../wire/frame.js';
import { PartitionStore } from './partition.js';
import type { Partition } from '../../wire/partition_message.js';

export interface Shown {
  readonly partition: Partition;
  readonly frame: Pick<Frame, 'frameId' | 'width' | 'height'>; // the picture it belongs to
}

export class ShownPartition {
  private readonly waiting_ = new PartitionStore();
  private shown_: Shown | null = null;

  /** `wanted`: whether the viewer wants to see partitions; `changed` is called when another one or none is shown. */
  constructor(
    private readonly wanted_: () => boolean,
    private readonly changed_: () => void,
  ) {}

  /** Null: nothing is to be shown. */
  get shown(): Shown | null {
    return this.shown_;
  }

  received(partition: Partition): void {
    this.waiting_.put(partition);
  }

  /** A picture is put on the canvas. */
  drawn(frame: Shown['frame']): void {
    const partition = this.waiting_.take(frame.frameId);
    this.show(partition === null || !this.wanted_() ? null : { partition, frame });
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

  private show(shown: Shown | null): void {
    if (shown === null && this.shown_ === null) return;
    this.shown_ = shown;
    this.changed_();
  }
}
