// Remembers how the viewer likes the page, in this browser only. A browser that refuses storage just forgets.

const PREFIX = 'heliograph.';

export function remember(key: string, value: string): void {
  try {
    localStorage.setItem(PREFIX + key, value);
  } catch {
    // Storage is off or full: the page works, it only starts with its defaults next time.
  }
}

export function recall(key: string): string | null {
  try {
    return localStorage.getItem(PREFIX + key);
  } catch {
    return null;
  }
}
