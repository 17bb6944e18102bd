// The pixel ratio changes without a change of the window's size: on another monitor, or where the two cancel out. Media
// queries tell of it in some cases only, so it is looked at twice a second.

const LOOK_MS = 500;

/** Calls `changed` whenever the pixel ratio has changed. */
export function onPixelRatio(changed: () => void): void {
  let ratio = window.devicePixelRatio;
  window.setInterval(() => {
    if (window.devicePixelRatio === ratio) return;
    ratio = window.devicePixelRatio;
    changed();
  }, LOOK_MS);
}
