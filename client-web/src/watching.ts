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

export class Watching {
  private active_ = false;

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

  /** A connection is open. The view to ask for; null: the page drives its own. */
  begin(): string | null {
    this.active_ = this.view_ !== null;
    return this.view_;
  }

  /** The server says who drives. True where the page drives from now on and did not before. */
  answered(drives: boolean): boolean {
    const began = this.active_ && drives;
    this.active_ = !drives;
    return began;
  }

  /** The view to watch is not there, or is wanted no longer. */
  giveUp(): void {
    this.view_ = null;
    this.active_ = false;
  }

  /** The viewer wants a view of its own, which the server has still to answer. */
  leave(): void {
    this.view_ = null;
  }

  /** Whether these settings may be sent. */
  maySet(names: readonly string[]): boolean {
    return !this.active_ || names.every((name) => name === OWN_SETTING);
  }
}
