// What is known of the effects' costs in the scene that is shown: asked for by the viewer, measured by the server.

import type { EffectCosts, EffectCostsMessage } from '../../wire/effect_costs_message.js';

export type EffectCostState =
  | { readonly name: 'unknown' }
  | { readonly name: 'measuring'; readonly share: number } // 0..1 of the measuring
  | { readonly name: 'ready'; readonly costs: EffectCosts }
  | { readonly name: 'failed'; readonly message: string };

export class EffectCostModel {
  private state_: EffectCostState = { name: 'unknown' };

  constructor(private readonly changed_: () => void) {}

  get state(): EffectCostState {
    return this.state_;
  }

  asked(): void {
    this.set({ name: 'measuring', share: 0 });
  }

  /** The server's word, while `scene` is shown. */
  answered(message: EffectCostsMessage, scene: string): void {
    const waits = this.state_.name === 'measuring';
    if (message.state === 'failed') {
      if (waits) this.refused(message.what);
      return;
    }
    if (message.state === 'ready' && message.scene === scene) this.set({ name: 'ready', costs: message });
    else if (message.state === 'ready' && waits) this.refused(`The server measured another scene: ${message.scene}.`);
    else if (message.state === 'measuring' && waits) this.set({ name: 'measuring', share: message.share });
  }

  refused(message: string): void {
    this.set({ name: 'failed', message });
  }

  /** Another scene is shown: nothing is known of it. */
  sceneChanged(): void {
    this.set({ name: 'unknown' });
  }

  /** What was being measured will not be answered; what was measured stays true. */
  disconnected(): void {
    if (this.state_.name === 'measuring') this.set({ name: 'unknown' });
  }

  private set(state: EffectCostState): void {
    this.state_ = state;
    this.changed_();
  }
}
