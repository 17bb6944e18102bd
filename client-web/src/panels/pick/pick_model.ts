// What the viewer pointed at: the last place, and the one before where two are measured. Knows no DOM.

import { length, subtract } from '../../camera/vector.js';
import type { PickedMessage, PickedSurface } from '../../wire/picked_message.js';

export type PickState =
  | { readonly name: 'none' }
  | { readonly name: 'asked' }
  | { readonly name: 'nothing' } // is there
  | { readonly name: 'found'; readonly surface: PickedSurface };

export class PickModel {
  private state_: PickState = { name: 'none' };
  private from_: PickedSurface | null = null;
  private focused_: PickedSurface | null = null;
  private asked_ = 0;

  /** `send`: the question `id` about a place of the picture, each 0..1 from its top left corner. */
  constructor(
    private readonly send_: (id: number, x: number, y: number) => void,
    private readonly changed_: () => void,
  ) {}

  get state(): PickState {
    return this.state_;
  }

  /** Where measuring begins; null while nothing is measured. */
  get from(): PickedSurface | null {
    return this.from_;
  }

  /** What was focused on, by the viewer's wish. */
  get focused(): PickedSurface | null {
    return this.focused_;
  }

  /** Metres between both points; null before there are two. */
  get measured(): number | null {
    if (this.from_ === null || this.state_.name !== 'found' || this.state_.surface === this.from_) return null;
    return length(subtract(this.state_.surface.position, this.from_.position));
  }

  ask(x: number, y: number): void {
    this.asked_ += 1;
    this.send_(this.asked_, x, y);
    this.set({ name: 'asked' });
  }

  /** Answers to older questions count for nothing. */
  answered({ id, surface }: PickedMessage): void {
    if (id !== this.asked_ || this.state_.name !== 'asked') return;
    this.set(surface === null ? { name: 'nothing' } : { name: 'found', surface });
  }

  measure(): void {
    if (this.state_.name !== 'found') return;
    this.from_ = this.state_.surface;
    this.changed_();
  }

  focusOn(surface: PickedSurface): void {
    this.focused_ = surface;
    this.changed_();
  }

  /** Another scene, or the viewer has seen enough. */
  forget(): void {
    this.from_ = null;
    this.focused_ = null;
    this.set({ name: 'none' });
  }

  private set(state: PickState): void {
    this.state_ = state;
    this.changed_();
  }
}
