// What limits the moving picture, and at rest that it is exact, beside the scene's name.

import { el, setText } from './dom.js';
import { denoisedText, exactText, paceText, type PaceText } from '../picture/pace_text.js';
import type { Viewer } from '../viewer.js';

export class LimitBadge {
  readonly element: HTMLElement;
  private readonly label_ = el('span', { class: 'limit-label' });
  private readonly figure_ = el('span', { class: 'limit-figure' });

  constructor(private readonly viewer_: Viewer) {
    this.element = el('span', { class: 'limit', hidden: true }, this.label_, this.figure_);
    viewer_.on(['frame', 'stats', 'connection'], () => this.refresh());
  }

  private refresh(): void {
    const text = this.text();
    this.element.hidden = text === null;
    if (text === null) return;
    setText(this.label_, text.label);
    setText(this.figure_, text.figure);
    if (this.element.title !== text.help) this.element.title = text.help;
  }

  private text(): PaceText | null {
    const { connection, lastFrame, stats } = this.viewer_.state;
    if (connection.name !== 'open' || lastFrame === null) return null;
    if (lastFrame.exact) return (lastFrame.denoised ? denoisedText : exactText)(lastFrame.samples);
    return lastFrame.moving && stats !== null && stats.pace !== null ? paceText(stats.pace) : null;
  }
}
