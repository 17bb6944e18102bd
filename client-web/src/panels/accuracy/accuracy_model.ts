// What is known of the accuracy of the view: asked for by the viewer, measured by the server. Knows no DOM.

import type { Camera } from '../../camera/camera.js';
import type { PictureSize } from '../../picture/resolution.js';
import type { Accuracy, AccuracyMessage } from '../../wire/accuracy_message.js';
import type { SettingValues } from '../../wire/protocol.js';

/** A view as it was when it was asked for. */
export interface ViewThen {
  readonly camera: Camera;
  readonly values: SettingValues; // of all settings
  readonly size: PictureSize; // that was asked for
}

export interface Measured {
  readonly accuracy: Accuracy;
  readonly then: ViewThen;
}

export type AccuracyState =
  | { readonly name: 'idle' }
  | { readonly name: 'asked' } // the server has not answered yet
  | { readonly name: 'measuring'; readonly share: number; readonly what: string }
  | { readonly name: 'ending' } // asked to give it up
  | { readonly name: 'ended'; readonly text: string; readonly wrong: boolean } // without a result; `wrong`: nobody wished it
  | { readonly name: 'ready' };

export class AccuracyModel {
  private state_: AccuracyState = { name: 'idle' };
  private measured_: Measured | null = null;
  private asked_: ViewThen | null = null; // that the server may still answer
  private late_ = false; // the server has still to say that what a new scene ended is given up

  /** `send_`: asks the server to measure for so many seconds, or by 0 to give it up. */
  constructor(
    private readonly send_: (seconds: number) => void,
    private readonly changed_: () => void,
  ) {}

  get state(): AccuracyState {
    return this.state_;
  }

  /** The newest result of the scene that is shown; it stays while another one is measured. */
  get measured(): Measured | null {
    return this.measured_;
  }

  /** The server measures, or was asked to. */
  get waits(): boolean {
    return this.state_.name === 'asked' || this.state_.name === 'measuring' || this.state_.name === 'ending';
  }

  ask(seconds: number, now: ViewThen): void {
    if (this.waits) return;
    this.asked_ = now;
    this.send_(seconds);
    this.set({ name: 'asked' });
  }

  giveUp(): void {
    if (!this.waits || this.state_.name === 'ending') return;
    this.send_(0);
    this.set({ name: 'ending' });
  }

  /** The server's word, while `scene` is shown. What nobody asked for is passed over. */
  answered(message: AccuracyMessage, scene: string): void {
    const late = this.late_;
    this.late_ = false;
    if (this.asked_ === null) return;
    switch (message.state) {
      case 'measuring':
        if (this.state_.name !== 'ending') this.set({ name: 'measuring', share: message.share, what: message.what });
        return;
      case 'given-up':
        if (late && this.state_.name === 'asked') return;
        return this.state_.name === 'ending' ? this.end('Given up.', false) : this.end('The server gave it up.', true);
      case 'failed':
        return this.end(`It could not be measured: ${message.what}`, true);
      case 'ready':
        if (message.scene !== scene) return this.end(`The server measured another scene: ${message.scene}.`, true);
        this.measured_ = { accuracy: message, then: this.asked_ };
        this.asked_ = null;
        return this.set({ name: 'ready' });
    }
  }

  /** The server's answer to what was asked is no. */
  refused(message: string): void {
    this.end(message, true);
  }

  /** Another scene is shown: what was measured is not of it. */
  sceneChanged(): void {
    const waited = this.waits;
    if (!waited && this.measured_ === null) return;
    this.measured_ = null;
    this.late_ = waited;
    this.end(waited ? 'Given up: another scene is shown.' : 'Another scene is shown: nothing is known of it yet.', waited);
  }

  /** Another viewer drives now: the server tells this page no more. */
  handedOver(): void {
    if (this.waits) this.end('Another viewer drives this view now.', true);
  }

  /** What comes after all, on the next connection to this view, counts. */
  disconnected(): void {
    if (this.waits) this.set({ name: 'ended', text: 'The connection was lost while it was measured.', wrong: true });
  }

  private end(text: string, wrong: boolean): void {
    this.asked_ = null;
    this.set({ name: 'ended', text, wrong });
  }

  private set(state: AccuracyState): void {
    this.state_ = state;
    this.changed_();
  }
}
