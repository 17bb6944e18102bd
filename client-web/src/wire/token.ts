// The token of a server that asks for one: from the page's address, `#token=…`, where it does not stay, or from the
// viewer. Kept for this tab only.

const KEY = 'heliograph.token';

/** The token of a page address; a fragment is never sent to a server. */
export function tokenOf(pageUrl: string): string | null {
  return new URLSearchParams(new URL(pageUrl).hash.slice(1)).get('token');
}

/** The page address without it; what else stands in the fragment stays. */
export function withoutToken(pageUrl: string): string {
  const url = new URL(pageUrl);
  const rest = url.hash.slice(1).split('&');
  url.hash = rest.filter((part) => part !== 'token' && !part.startsWith('token=')).join('&');
  return url.href;
}

export function keepToken(token: string): void {
  try {
    sessionStorage.setItem(KEY, token);
  } catch {
    // Storage is off: after a reload the token is asked for again.
  }
}

/** Of this tab. */
export function keptToken(): string | null {
  try {
    return sessionStorage.getItem(KEY);
  } catch {
    return null;
  }
}

/** Of the address, which is cleared of it, else the one kept. */
export function takeToken(): string | null {
  const token = tokenOf(location.href);
  if (token === null) return keptToken();
  keepToken(token);
  history.replaceState(history.state, '', withoutToken(location.href));
  return token;
}

/** Headers of a request to the server. */
export function authorization(): Readonly<Record<string, string>> {
  const token = keptToken();
  return token === null ? {} : { authorization: `Bearer ${token}` };
}
