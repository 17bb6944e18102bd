// What the page and the server say to each other about whose view is looked at: coming by a link, coming back after a lost
// connection, asking to drive, handing over. The rules stand in watching.ts.

import type { Camera } from './camera/camera.js';
import { DRIVEN_BY_OTHERS, Watching, withoutView, withView } from './watching.js';
import type { Hello, SceneMessage } from './wire/protocol.js';
import type { ViewerMessage } from './wire/viewer_message.js';
import type { WatchingMessage } from './wire/watching_message.js';

export interface SeatHooks {
  send(message: ViewerMessage): void;
  nextInputId(): number;
  notice(text: string): void;
  /** Who drives, or wants to, has changed. */
  changed(): void;
  /** Tells the server all that this page wants of its view. `restore`: also the scene that is shown, and the camera. */
  drive(restore: boolean): void;
  /** Goes on from where this view is. `now`: its scene is shown already. */
  goOn(camera: Camera | null, now: boolean): void;
  scene(message: SceneMessage): void;
}

export class Seat {
  readonly watching: Watching;
  private heldBack_: SceneMessage | null = null; // of the view that the page was greeted with

  constructor(
    private readonly hooks_: SeatHooks,
    view: string | null,
  ) {
    this.watching = new Watching(view);
  }

  greeted(hello: Hello): void {
    this.heldBack_ = null;
    const asked = this.watching.begin(hello.view, hello.key);
    if (asked === null) this.hooks_.drive(true);
    else this.hooks_.send({ type: 'watch', inputId: this.hooks_.nextInputId(), ...asked });
    this.hooks_.changed();
  }

  /** Keeps a scene of the page's own view back as long as another view was asked for; false: it is to be shown. */
  holdBack(message: SceneMessage): boolean {
    if (this.watching.awaits) this.heldBack_ = message;
    return this.watching.awaits;
  }

  answered({ view, drives, camera }: WatchingMessage): void {
    const { asks } = this.watching;
    const turn = this.watching.answered(view, drives);
    this.heldBack_ = null;
    this.hooks_.changed();
    if (turn === 'resumed' || turn === 'own') this.hooks_.drive(turn === 'resumed');
    if (turn === 'found' || turn === 'given') this.hooks_.goOn(camera, turn === 'given');
    if (turn === 'given')
      this.hooks_.notice(asks ? 'This view was handed to you. You drive it now.' : 'Who drove this view has left. You drive it now.');
    if (turn === 'kept') this.hooks_.notice('Who drives this view goes on driving it.');
    if (turn === 'handedOver') this.hooks_.notice('Another viewer drives this view now; you watch it.');
  }

  /** The view that was asked for is not there. True where that needs no words: what was seen is restored. */
  refused(): boolean {
    const resumed = this.watching.refused();
    this.hooks_.changed();
    this.hooks_.drive(resumed);
    const scene = this.heldBack_;
    this.heldBack_ = null;
    if (scene !== null) this.hooks_.scene(scene);
    return resumed;
  }

  /** The address at which others watch what is seen here; null while there is none. */
  shareAddress(): string | null {
    return this.watching.looked === null ? null : withView(location.href, this.watching.looked);
  }

  /** From a view of somebody else to one of one's own. */
  leave(): void {
    this.watching.leave();
    history.replaceState(null, '', withoutView(location.href));
    this.hooks_.send({ type: 'watch', inputId: this.hooks_.nextInputId() });
    this.hooks_.changed();
  }

  /** Who watches wants to drive. */
  askToDrive(): void {
    if (!this.watching.active || this.watching.asks) return;
    this.watching.ask();
    this.hooks_.send({ type: 'drive', inputId: this.hooks_.nextInputId() });
    this.hooks_.notice('Who drives this view was asked to hand it over.');
    this.hooks_.changed();
  }

  /** Another viewer wants to drive. */
  asked(viewer: number): void {
    this.watching.setAskedBy(viewer);
    this.hooks_.changed();
  }

  answer(handOver: boolean): void {
    const viewer = this.watching.askedBy;
    if (viewer === null) return;
    this.watching.setAskedBy(null);
    this.hooks_.send({ type: 'drive', inputId: this.hooks_.nextInputId(), viewer, refuse: !handOver });
    this.hooks_.changed();
  }

  /** Says so where another viewer drives. */
  drivenByOthers(): boolean {
    if (this.watching.active) this.hooks_.notice(DRIVEN_BY_OTHERS);
    return this.watching.active;
  }
}
