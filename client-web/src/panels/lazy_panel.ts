// Panels whose code comes only when they are first opened.

import { el } from '../page/dom.js';
import type { Panel } from './panel.js';

/** `load` answers what fills the panel. Where it cannot be had, the panel says so and the next opening tries again. */
export function whenFirstOpened(panel: Panel, load: () => Promise<() => void>): void {
  let asked = false;
  const remark = el('p', { class: 'muted', role: 'status' });
  const fill = async (): Promise<void> => {
    remark.textContent = 'Loading …';
    panel.body.append(remark);
    try {
      const make = await load();
      remark.remove();
      make();
    } catch (error) {
      if (!(error instanceof TypeError)) throw error; // of this page, not of the line
      remark.textContent = 'This part of the page could not be loaded. Open it again, or reload the page.';
      panel.body.append(remark);
      asked = false;
    }
  };
  panel.onToggle((open) => {
    if (!open || asked) return;
    asked = true;
    void fill();
  });
}
