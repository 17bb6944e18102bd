// After a reconnect: the scene that was shown before comes back, if the server still has it. Knows no DOM and no socket.

import { isUploaded } from './upload/upload_files.js';
import type { SceneMessage } from './wire/protocol.js';

/** What to do with the server's word on a scene. */
export interface SceneStep {
  readonly show: boolean;
  readonly ask: string | null; // the scene to ask the server for
}

const SHOW: SceneStep = { show: true, ask: null };

export class Restoring {
  private scene_: string | null = null;
  private asked_ = false;
  private looked_ = true;
  private kept_: SceneMessage | null = null;

  /** While true, frames show another scene than the one that was looked at. */
  get active(): boolean {
    return this.scene_ !== null;
  }

  /** A new connection is open; `scene` was shown on the one before. `looked`: from a place that is to stay. */
  begin(scene: string, looked = true): void {
    this.scene_ = scene;
    this.looked_ = looked;
    this.asked_ = false;
    this.kept_ = null;
  }

  /** The viewer wants something else. */
  cancel(): void {
    this.scene_ = null;
    this.kept_ = null;
  }

  /** `offered`: the names of the scenes that the server has. */
  step(message: SceneMessage, offered: readonly string[]): SceneStep {
    const scene = this.scene_;
    if (scene === null || message.name === scene) return SHOW;
    if (!offered.some((name) => scene === name || scene.startsWith(`${name}#`)) && !isUploaded(scene)) {
      this.cancel();
      return SHOW;
    }
    this.kept_ = message;
    const ask = this.asked_ ? null : scene;
    this.asked_ = true;
    return { show: false, ask };
  }

  /** Scene `name` is shown. True when it is the one from before, which is looked at from where it was. */
  finish(name: string): boolean {
    const restored = this.scene_ === name && this.looked_;
    this.cancel();
    return restored;
  }

  /** The scene from before cannot be had: answers the server's own, to be shown instead, if there was a word on it. */
  giveUp(): SceneMessage | null {
    const kept = this.kept_;
    this.cancel();
    return kept;
  }
}
