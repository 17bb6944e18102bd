// Why the server lets this page not in. Browsers hide the answer to a WebSocket that is refused, so the page asks once more
// by an ordinary request to the same address. Knows no DOM.

/** What the server, or what stands before it, answered. */
export interface RefusalAnswer {
  readonly status: number;
  readonly text: string;
  readonly retryAfter: number; // s; 0: it did not say
}

export interface Refusal {
  readonly title: string;
  readonly advice: string; // what to do; '': wait
  readonly retryAfter: number; // s
}

const LONGEST_WORDS = 160;

const quoted = (text: string): string => {
  const words = text.trim();
  const readable = words !== '' && words.length <= LONGEST_WORDS && !words.includes('<');
  return readable ? ` (${words})` : '';
};

/** `origin`: of this page. */
export function refusalOf({ status, text, retryAfter }: RefusalAnswer, origin: string): Refusal {
  const words = quoted(text);
  const refusal = (title: string, advice: string): Refusal => ({ title, advice, retryAfter });
  switch (status) {
    case 403:
    case 421:
      return refusal(
        `The server takes no pages from ${origin}`,
        `Who runs it can allow that: --allow-origin ${origin}. A proxy has to hand on the Host header.`,
      );
    case 426:
      return refusal('The server is there, but no WebSocket reaches it', 'A proxy on the way has to hand on Upgrade.');
    case 429:
      return refusal(`The server makes this address wait${words}`, '');
    case 502:
    case 504:
      return refusal('The proxy does not reach the server', '');
    case 503:
      return refusal(`The server has no room${words}`, '');
    default:
      return refusal(`The server refuses the connection: HTTP ${status}${words}`, '');
  }
}

/** Asks at `socketUrl`; null where nobody answers. */
export async function askRefusal(socketUrl: string, origin: string): Promise<Refusal | null> {
  const url = socketUrl.replace(/^ws/, 'http');
  try {
    // Only a POST tells the page's origin.
    const response = await fetch(url, { method: 'POST', cache: 'no-store', signal: AbortSignal.timeout(5000) });
    const retryAfter = Number(response.headers.get('retry-after') ?? 0);
    const text = await response.text();
    return refusalOf({ status: response.status, text, retryAfter: Number.isFinite(retryAfter) ? retryAfter : 0 }, origin);
  } catch {
    return null;
  }
}
