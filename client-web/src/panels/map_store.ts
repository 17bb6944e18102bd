// What came for frames that are still on their way.

import { isNewer } from '../picture/frame_queue.js';

export class MapStore<T extends { readonly frameId: number }> {
  private waiting_: readonly T[] = [];

  put(map: T): void {
    // No more frames than this are ever on their way; what is older has lost its frame.
    this.waiting_ = [...this.waiting_.filter((entry) => entry.frameId !== map.frameId), map].slice(-8);
  }

  /** The one that came with this frame, or null; it and all older ones are forgotten. */
  take(frameId: number): T | null {
    const found = this.waiting_.find((entry) => entry.frameId === frameId) ?? null;
    this.waiting_ = this.waiting_.filter((entry) => isNewer(entry.frameId, frameId));
    return found;
  }

  clear(): void {
    this.waiting_ = [];
  }
}
