// The page over the whole screen, where the browser can.

import { iconButton } from './dom.js';

export function toggleFullScreen(): void {
  // A browser that refuses leaves the page as it is; nothing is lost.
  if (document.fullscreenElement === null) document.documentElement.requestFullscreen().catch(() => undefined);
  else document.exitFullscreen().catch(() => undefined);
}

export function fullScreenButton(): HTMLButtonElement {
  const button = iconButton('full', 'Full screen', '', 'tool icon-only full-screen');
  button.hidden = !document.fullscreenEnabled;
  button.setAttribute('aria-pressed', 'false');
  button.addEventListener('click', toggleFullScreen);
  document.addEventListener('fullscreenchange', () =>
    button.setAttribute('aria-pressed', String(document.fullscreenElement !== null)),
  );
  return button;
}
