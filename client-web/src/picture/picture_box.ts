// Where the picture lies in the window: it covers the window, so of a picture of another shape two sides are cut off.

export interface Box {
  readonly x: number; // CSS pixels from the window's left, negative where the picture is cut off
  readonly y: number;
  readonly width: number;
  readonly height: number;
}

/** The box of a picture of `width` x `height` that covers a window of `windowWidth` x `windowHeight`, centred. */
export function pictureBox(width: number, height: number, windowWidth: number, windowHeight: number): Box {
  const scale = Math.max(windowWidth / width, windowHeight / height);
  const shown = { width: width * scale, height: height * scale };
  return { x: (windowWidth - shown.width) / 2, y: (windowHeight - shown.height) / 2, ...shown };
}

/** A place in the window as 0..1 of the picture from its top left corner; null beside the picture. */
export function placeInPicture(box: Box, x: number, y: number): { readonly x: number; readonly y: number } | null {
  const place = { x: (x - box.x) / box.width, y: (y - box.y) / box.height };
  return place.x >= 0 && place.x <= 1 && place.y >= 0 && place.y <= 1 ? place : null;
}
