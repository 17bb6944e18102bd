// The connection: opens the WebSocket, keeps it alive, and opens it again after it was lost.

import { PROTOCOL } from './protocol.js';
import { askRefusal, type Refusal } from './refusal.js';
import type { ViewerMessage } from './viewer_message.js';

export type ConnectionState =
  | { readonly name: 'connecting'; readonly refusal: Refusal | null } // refusal: of the attempt before
  | { readonly name: 'open' }
  // retryAt: performance.now()
  | { readonly name: 'waiting'; readonly retryAt: number; readonly reason: string; readonly refusal: Refusal | null }
  | { readonly name: 'stopped'; readonly reason: string; readonly wantsToken: boolean };

export interface ConnectionHooks {
  state(state: ConnectionState): void;
  text(text: string): void;
  binary(buffer: ArrayBuffer): void;
}

const FIRST_DELAY = 250; // ms
const LONGEST_DELAY = 5000; // ms
const PING_INTERVAL = 2000; // ms
const PING_AT_REST = 8000; // ms, once nothing was said for
const REST = 10_000; // ms
const SILENCE_LIMIT = 10_000; // ms that a ping may stay without any answer

const UNAUTHORIZED = 4001; // close codes
const DISMISSED = 4003;
const NEEDS_TOKEN = 'This server asks for a token.';
const WRONG_TOKEN = 'The server refused the token.';
const LONGEST_WAIT = 30; // s that a server may ask a refused page to wait

/**
 * Milliseconds to wait before attempt `attempt` (0 first). `random` in [0, 1) spreads viewers of one server by 20 %.
 */
export function backoffDelay(attempt: number, random: number): number {
  const delay = Math.min(LONGEST_DELAY, FIRST_DELAY * 2 ** Math.min(attempt, 10));
  return delay * (0.9 + 0.2 * random);
}

/** Address of the WebSocket beside a page at `pageUrl`. */
export function socketUrl(pageUrl: string): string {
  const url = new URL('ws', pageUrl);
  url.protocol = url.protocol === 'https:' ? 'wss:' : 'ws:';
  url.hash = '';
  return url.href;
}

export class Connection {
  private socket_: WebSocket | null = null;
  private attempt_ = 0;
  private retryTimer_ = 0;
  private pingTimer_ = 0;
  private unansweredSince_: number | null = null;
  private saidAt_ = 0; // anything but pings
  private pingedAt_ = 0;
  private refusal_: Refusal | null = null; // of the newest attempt that was refused
  /** Of the newest ping that was answered, told with the next one; null on a new connection. */
  roundTripMs: number | null = null;

  constructor(
    private readonly url_: string,
    private readonly hooks_: ConnectionHooks,
    private token_: string | null = null,
  ) {}

  /** Said from the next connection on, which is opened now unless there is one. */
  setToken(token: string): void {
    this.token_ = token;
    if (!this.isOpen) this.open();
  }

  get isOpen(): boolean {
    return this.socket_?.readyState === WebSocket.OPEN;
  }

  /** Opens now, also while waiting for the next attempt. */
  open(): void {
    window.clearTimeout(this.retryTimer_);
    this.abandon();
    this.hooks_.state({ name: 'connecting', refusal: this.refusal_ });
    const socket = new WebSocket(this.url_, PROTOCOL);
    socket.binaryType = 'arraybuffer';
    this.socket_ = socket;
    let opened = false;
    socket.onopen = () => {
      opened = true;
      this.refusal_ = null;
      if (this.token_ !== null) this.send({ type: 'token', token: this.token_ });
      this.pingTimer_ = window.setInterval(() => this.ping(), PING_INTERVAL);
      this.hooks_.state({ name: 'open' });
      this.ping();
    };
    socket.onmessage = (event: MessageEvent<string | ArrayBuffer>) => {
      this.unansweredSince_ = null;
      if (typeof event.data === 'string') this.hooks_.text(event.data);
      else this.hooks_.binary(event.data);
    };
    socket.onclose = (event) => {
      if (event.code === UNAUTHORIZED) this.stop(this.token_ === null ? NEEDS_TOKEN : WRONG_TOKEN, true);
      else if (event.code === DISMISSED) this.stop('The operator of the server closed this connection.');
      else this.lost(event.reason);
      if (!opened) void this.explain();
    };
  }

  /** Closes for good; `reason` is shown. */
  stop(reason: string, wantsToken = false): void {
    window.clearTimeout(this.retryTimer_);
    this.abandon();
    this.hooks_.state({ name: 'stopped', reason, wantsToken });
  }

  /** The server speaks the protocol: the next loss starts with the shortest delay again. */
  confirm(): void {
    this.attempt_ = 0;
  }

  /** Sends when open; what cannot be sent is dropped, since state is restored after the next connect. */
  send(message: ViewerMessage): void {
    if (message.type !== 'ping') this.saidAt_ = performance.now();
    if (this.isOpen) this.socket_?.send(JSON.stringify(message));
  }

  private ping(): void {
    const now = performance.now();
    if (this.unansweredSince_ !== null && now - this.unansweredSince_ > SILENCE_LIMIT) {
      this.lost('the server does not answer');
      return;
    }
    if (now - this.saidAt_ > REST && now - this.pingedAt_ < PING_AT_REST - PING_INTERVAL / 2) return;
    this.pingedAt_ = now;
    this.unansweredSince_ ??= now;
    this.send({ type: 'ping', time: now, roundTripMs: this.roundTripMs });
  }

  private lost(reason: string): void {
    this.abandon();
    const delay = backoffDelay(this.attempt_, Math.random());
    this.attempt_ += 1;
    this.retryIn(delay, reason);
  }

  private retryIn(delay: number, reason: string): void {
    window.clearTimeout(this.retryTimer_);
    this.hooks_.state({ name: 'waiting', retryAt: performance.now() + delay, reason, refusal: this.refusal_ });
    this.retryTimer_ = window.setTimeout(() => this.open(), delay);
  }

  /** A WebSocket was refused: learns why, and waits as long as the server asks for. */
  private async explain(): Promise<void> {
    const attempt = this.attempt_;
    this.refusal_ = await askRefusal(this.url_, location.origin);
    if (attempt !== this.attempt_ || this.socket_ !== null) return;
    const asked = 1000 * Math.min(LONGEST_WAIT, this.refusal_?.retryAfter ?? 0);
    this.retryIn(Math.max(asked, backoffDelay(attempt - 1, Math.random())), '');
  }

  /** Lets go of the present socket without hearing from it again. */
  private abandon(): void {
    window.clearInterval(this.pingTimer_);
    this.unansweredSince_ = this.roundTripMs = null;
    const socket = this.socket_;
    this.socket_ = null;
    if (socket === null) return;
    socket.onopen = socket.onmessage = socket.onclose = null;
    socket.close();
  }
}
