// What the viewer has the server measure: the costs of the effects, and the accuracy of the view.

import { AccuracyModel, type ViewThen } from './panels/accuracy/accuracy_model.js';
import { EffectCostModel } from './panels/effects/effect_costs.js';
import type { AccuracyMessage } from './wire/accuracy_message.js';
import type { EffectCostsMessage } from './wire/effect_costs_message.js';
import type { ViewerMessage } from './wire/viewer_message.js';

export interface MeasuringHooks {
  send(message: ViewerMessage): void;
  changed(topic: 'effectCosts' | 'accuracy'): void;
  /** Whether there is a scene, a connection and the right to ask; who has no right is told so. */
  may(): boolean;
  /** The view as it is now. */
  now(): ViewThen;
}

export class Measuring {
  readonly effects: EffectCostModel;
  readonly accuracy: AccuracyModel;

  constructor(private readonly hooks_: MeasuringHooks) {
    this.effects = new EffectCostModel(() => hooks_.changed('effectCosts'));
    this.accuracy = new AccuracyModel(
      (seconds) => hooks_.send({ type: 'accuracy', seconds }),
      () => hooks_.changed('accuracy'),
    );
  }

  /** Asks what each effect costs here. */
  measureEffects(): void {
    if (!this.hooks_.may() || this.effects.state.name === 'measuring') return;
    this.hooks_.send({ type: 'effectCosts' });
    this.effects.asked();
  }

  /** Asks what each setting costs here and how far from exact its picture is. */
  measureView(seconds: number): void {
    if (this.hooks_.may()) this.accuracy.ask(seconds, this.hooks_.now());
  }

  /** While `scene` is shown. */
  answered(message: EffectCostsMessage | AccuracyMessage, scene: string): void {
    if (message.type === 'accuracy') this.accuracy.answered(message, scene);
    else this.effects.answered(message, scene);
  }

  /** An error of the server; false: it is about something else. */
  refused(message: string, about: string): boolean {
    if (about === 'effectCosts') this.effects.refused(message);
    else if (about === 'accuracy') this.accuracy.refused(message);
    return about === 'effectCosts' || about === 'accuracy';
  }

  sceneChanged(): void {
    this.effects.sceneChanged();
    this.accuracy.sceneChanged();
  }

  disconnected(): void {
    this.effects.disconnected();
    this.accuracy.disconnected();
  }
}
