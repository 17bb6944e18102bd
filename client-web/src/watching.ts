// Whose view is looked at: one's own, or one that another viewer drives. Knows no DOM and no socket.

/** Said to who watches and wants to drive. */
export const DRIVEN_BY_OTHERS = 'You watch a view of somebody else: camera and settings are theirs.';

/** What a viewer who watches may set. */
const OWN_SETTING = 'jpegQuality';

/** The view that a page address asks to watch, `?view=…`. */
export function viewOf(pageUrl: string): string | null {
  return new URL(pageUrl).searchParams.get('view') || null;
}

/** The page address of a view of one's own. */
export function withoutView(pageUrl: string): string {
  const url = new URL(pageUrl);
  url.searchParams.delete('view');
  return url.href;
}

/** The page address at which a view is watched. It bears no token: who opens it needs one of its own, where the server asks. */
export function withView(pageUrl: string, view: string): string {
  const url = new URL(withoutView(pageUrl));
  url.searchParams.set('view', view);
  url.hash = '';
  return url.href;
}

/** What a word of the server on who drives means for the page. */
export type Turn =
  | 'resumed' // it drives the view that it drove on the connection before
  | 'own' // it drives a new view of its own, as it asked for
  | 'found' // it drives the view that it asked to watch: nobody else looks at it
  | 'given' // it drives from now on, as the one before has left or handed over
  | 'handedOver' // it drove until now
  | 'kept' // it asked to drive, and who drives goes on
  | 'none';

/** What to ask of the server: this view; `key` proves who sat there on the connection before. */
export interface Asked {
  readonly view: string;
  readonly key: string;
}

export class Watching {
  private active_ = false;
  private awaits_: 'view' | 'own' | null = null;
  private looked_: { view: string; drives: boolean; key: string } | null = null;
  private own_ = { view: '', key: '' }; // of the present connection
  private resumes_ = false;
  private asks_ = false;
  private askedBy_: number | null = null;

  /** `view_`: the one to watch; null: one's own. */
  constructor(private view_: string | null) {}

  /** Another viewer drives what is seen, or will when the server has answered: nothing that drives may be sent. */
  get active(): boolean {
    return this.active_;
  }

  /** The view that was asked for; null: one's own. */
  get view(): string | null {
    return this.view_;
  }

  /** The view that is looked at; null before a server has answered. */
  get looked(): string | null {
    return this.looked_?.view ?? null;
  }

  /** The server has still to say whose view is looked at. */
  get awaits(): boolean {
    return this.awaits_ !== null;
  }

  /** This page has asked to drive. */
  get asks(): boolean {
    return this.asks_;
  }

  /** The number of a viewer who wants to drive what this page drives. */
  get askedBy(): number | null {
    return this.askedBy_;
  }

  /**
   * A connection is open, on which the page was given a view of its own and the key to its seats. What to ask for: after a
   * lost connection the view from before, else that of the address; null: the page drives its own.
   */
  begin(own: string, key: string): Asked | null {
    const former = this.looked_;
    this.own_ = { view: own, key };
    this.resumes_ = former?.drives ?? false;
    this.asks_ = false;
    this.askedBy_ = null;
    const view = former?.view ?? this.view_;
    this.active_ = view !== null;
    this.awaits_ = view === null ? null : 'view';
    if (view !== null) return { view, key: former?.key ?? '' };
    if (own !== '') this.looked_ = { view: own, drives: true, key }; // a server without views of its own names none
    return null;
  }

  /** The server says who drives. */
  answered(view: string, drives: boolean): Turn {
    const turn = this.turn(drives);
    this.asks_ = false;
    this.looked_ = { view, drives, key: this.own_.key };
    this.active_ = !drives;
    this.awaits_ = null;
    this.askedBy_ = null;
    return turn;
  }

  private turn(drives: boolean): Turn {
    if (!this.active_) return drives ? 'none' : 'handedOver';
    if (!drives) return this.asks_ && !this.awaits ? 'kept' : 'none';
    if (this.awaits_ === null) return 'given';
    if (this.awaits_ === 'own') return 'own';
    return this.resumes_ ? 'resumed' : 'found';
  }

  /** The view that was asked for is not there: the page drives its own. True where it drove that view before. */
  refused(): boolean {
    const resumed = this.resumes_ && this.awaits_ === 'view';
    this.view_ = null;
    this.active_ = this.resumes_ = false;
    this.awaits_ = null;
    this.looked_ = { ...this.own_, drives: true };
    return resumed;
  }

  /** The viewer wants a view of its own, which the server has still to answer. */
  leave(): void {
    this.view_ = null;
    this.awaits_ = 'own';
    this.asks_ = false;
  }

  /** The viewer wants to drive. */
  ask(): void {
    this.asks_ = this.active_;
  }

  /** Another viewer wants to drive; null: it was answered. */
  setAskedBy(viewer: number | null): void {
    this.askedBy_ = this.active_ ? null : viewer;
  }

  /** Whether these settings may be sent. */
  maySet(names: readonly string[]): boolean {
    return !this.active_ || names.every((name) => name === OWN_SETTING);
  }
}
