// Views that the viewer keeps in this browser: where they are, how they look small. Knows no DOM.

export interface SavedView {
  readonly name: string;
  readonly fragment: string; // of the page's address, without the leading #
  readonly picture: string; // a data: address of an image, or ''
}

export const MOST_VIEWS = 24;
const LONGEST_FRAGMENT = 8000; // characters
const LONGEST_PICTURE = 20_000;

const isText = (value: unknown, longest: number): value is string => typeof value === 'string' && value.length <= longest;

/** What the browser has kept; what cannot be read is left out. */
export function savedViews(stored: string | null): readonly SavedView[] {
  let list: unknown = [];
  try {
    list = JSON.parse(stored ?? '[]');
  } catch {
    return [];
  }
  if (!Array.isArray(list)) return [];
  return list.slice(0, MOST_VIEWS).flatMap((entry: unknown) => {
    const { name, fragment, picture } = (entry ?? {}) as Record<string, unknown>;
    if (!isText(name, 200) || !isText(fragment, LONGEST_FRAGMENT) || !isText(picture, LONGEST_PICTURE)) return [];
    return [{ name, fragment, picture: picture.startsWith('data:image/') ? picture : '' }];
  });
}

/** With this one first; one of the same place goes, and so does the oldest where there are too many. */
export function withSaved(views: readonly SavedView[], view: SavedView): readonly SavedView[] {
  return [view, ...views.filter(({ fragment }) => fragment !== view.fragment)].slice(0, MOST_VIEWS);
}

/** "Cornell 2": the scene's name and a number that none of the others has. */
export function nameFor(scene: string, views: readonly SavedView[]): string {
  for (let number = 1; ; number += 1) {
    const name = `${scene} ${number}`;
    if (!views.some((view) => view.name === name)) return name;
  }
}
