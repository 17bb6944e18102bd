// The connection: opens the WebSocket, keeps it alive, and opens it again after it was lost.

import { PROTOCOL } from './protocol.js';
import type { ViewerMessage } from './viewer_message.js';

export type ConnectionState =
  | { readonly name: 'connecting' }
  | { readonly name: 'open' }
  | { readonly name: 'waiting'; readonly retryAt: number; readonly reason: string } // retryAt: performance.now()
  | { readonly name: 'stopped'; readonly reason: string };

export interface ConnectionHooks {
  state(state: ConnectionState): void;
  text(text: string): void;
  binary(buffer: ArrayBuffer): void;
}

const FIRST_DELAY = 250; // ms
const LONGEST_DELAY = 5000; // ms
const PING_INTERVAL = 2000; // ms
const SILENCE_LIMIT = 10_000; // ms that a ping may stay without any answer

const UNAUTHORIZED = 4001; // close codes
const DISMISSED = 4003;
const NEEDS_TOKEN = 'This server asks for a token. Add #token=… to the address of the page.';
const WRONG_TOKEN = 'The server refused the token. Check #token=… in the address of the page and reload it.';

/** The token of a page address that ends in `#token=…`; a fragment is never sent to a server. */
export function tokenOf(pageUrl: string): string | null {
  return new URLSearchParams(new URL(pageUrl).hash.slice(1)).get('token');
}

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
  /** Of the newest ping that was answered, told with the next one; null on a new connection. */
  roundTripMs: number | null = null;

  constructor(
    private readonly url_: string,
    private readonly hooks_: ConnectionHooks,
    private readonly token_: string | null = null,
  ) {}

  get isOpen(): boolean {
    return this.socket_?.readyState === WebSocket.OPEN;
  }

  /** Opens now, also while waiting for the next attempt. */
  open(): void {
    window.clearTimeout(this.retryTimer_);
    this.abandon();
    this.hooks_.state({ name: 'connecting' });
    const socket = new WebSocket(this.url_, PROTOCOL);
    socket.binaryType = 'arraybuffer';
    this.socket_ = socket;
    socket.onopen = () => {
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
      if (event.code === UNAUTHORIZED) this.stop(this.token_ === null ? NEEDS_TOKEN : WRONG_TOKEN);
      else if (event.code === DISMISSED) this.stop('The operator of the server closed this connection.');
      else this.lost(event.reason);
    };
  }

  /** Closes for good; `reason` is shown. */
  stop(reason: string): void {
    window.clearTimeout(this.retryTimer_);
    this.abandon();
    this.hooks_.state({ name: 'stopped', reason });
  }

  /** The server speaks the protocol: the next loss starts with the shortest delay again. */
  confirm(): void {
    this.attempt_ = 0;
  }

  /** Sends when open; what cannot be sent is dropped, since state is restored after the next connect. */
  send(message: ViewerMessage): void {
    if (this.isOpen) this.socket_?.send(JSON.stringify(message));
  }

  private ping(): void {
    const now = performance.now();
    if (this.unansweredSince_ !== null && now - this.unansweredSince_ > SILENCE_LIMIT) {
      this.lost('the server does not answer');
      return;
    }
    this.unansweredSince_ ??= now;
    this.send({ type: 'ping', time: now, roundTripMs: this.roundTripMs });
  }

  private lost(reason: string): void {
    this.abandon();
    const delay = backoffDelay(this.attempt_, Math.random());
    this.attempt_ += 1;
    this.hooks_.state({ name: 'waiting', retryAt: performance.now() + delay, reason });
    this.retryTimer_ = window.setTimeout(() => this.open(), delay);
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
