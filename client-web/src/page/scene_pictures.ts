// Small pictures of the server's scenes. Those that can be seen are asked for, one after the other; what the server has still to
// make is asked for again as long as it can be seen. Where the server does not know the token any more nothing is asked for: each
// wrong one counts towards locking this address out.

import { authorization } from '../wire/token.js';

const AGAIN = 1500; // ms
const COMING = 202; // HTTP
const NOT_OFFERED = 404;
const WRONG_TOKEN = [401, 429];

export class ScenePictures {
  private readonly there_ = new Map<string, string>(); // addresses by name; '' where there is none
  private readonly shown_ = new Map<Element, string>(); // names of images that can be seen and have no picture yet
  private readonly watch_ = new IntersectionObserver((entries) => this.seen(entries));
  private readonly names_ = new WeakMap<Element, string>();
  private asking_ = false;
  private refused_ = false;

  /** Puts the picture into the image, once it is there and can be seen. */
  show(image: HTMLImageElement, scene: string): void {
    const address = this.there_.get(scene);
    if (address !== undefined) return put(image, address);
    this.names_.set(image, scene);
    this.watch_.observe(image);
  }

  /** Another server: it may have other scenes of these names. */
  forget(): void {
    for (const address of this.there_.values()) URL.revokeObjectURL(address);
    this.there_.clear();
    this.refused_ = false;
  }

  private seen(entries: readonly IntersectionObserverEntry[]): void {
    for (const { target, isIntersecting } of entries) {
      const name = this.names_.get(target);
      if (isIntersecting && name !== undefined) this.shown_.set(target, name);
      else this.shown_.delete(target);
      if (!target.isConnected) this.watch_.unobserve(target);
    }
    if (!this.asking_ && !this.refused_) void this.askAll();
  }

  /** Until all that can be seen have theirs. */
  private async askAll(): Promise<void> {
    this.asking_ = true;
    while (this.shown_.size > 0 && !this.refused_) {
      const before = this.there_.size;
      for (const [image, name] of [...this.shown_]) await this.ask(image, name);
      if (this.shown_.size > 0 && this.there_.size === before) await new Promise((done) => setTimeout(done, AGAIN));
    }
    this.asking_ = false;
  }

  private async ask(image: Element, name: string): Promise<void> {
    if (!this.shown_.has(image) || this.refused_) return; // out of sight meanwhile
    const address = this.there_.get(name) ?? (await this.fetched(name));
    if (address === null) return;
    this.there_.set(name, address);
    this.shown_.delete(image);
    this.watch_.unobserve(image);
    if (image instanceof HTMLImageElement) put(image, address);
  }

  /** Null where it is not there yet; '' where there will be none. */
  private async fetched(scene: string): Promise<string | null> {
    try {
      const answer = await fetch(`thumbnails/${encodeURIComponent(scene)}`, { headers: authorization() });
      this.refused_ ||= WRONG_TOKEN.includes(answer.status);
      if (answer.status === NOT_OFFERED) return '';
      if (!answer.ok || answer.status === COMING) return null;
      const picture = await answer.blob();
      return picture.size > 0 ? URL.createObjectURL(picture) : '';
    } catch {
      return null; // the line is broken
    }
  }
}

function put(image: HTMLImageElement, address: string): void {
  if (address !== '') image.src = address;
}
