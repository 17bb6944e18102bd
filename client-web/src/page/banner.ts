// What the viewer waits for: a lost connection, a scene that loads; and how a benchmark path ended.

import { el, icon, setText } from './dom.js';
import { compact } from './format.js';
import type { PathResult } from '../wire/protocol.js';
import { displayName } from './scene_name.js';
import { TokenForm } from './token_form.js';
import type { Viewer } from '../viewer.js';
import './banner.css';

/** What a button says and does. */
type Act = readonly [string, () => void];

export class Banner {
  readonly element = el('div', { class: 'banner', hidden: true });
  private readonly title_ = el('strong');
  private readonly text_ = el('span', { class: 'banner-text' });
  private readonly progress_ = el('progress', { max: 1 });
  private readonly token_ = new TokenForm((token) => this.viewer_.giveToken(token));
  private readonly buttons_ = [0, 1].map(() => el('button', { type: 'button', class: 'wide-button' }));
  private acts_: readonly Act[] = [];
  private closedResult_: PathResult | null = null;

  /** `announce` tells assistive technology of a change, without the running figures. */
  constructor(
    private readonly viewer_: Viewer,
    private readonly announce_: (text: string) => void,
  ) {
    this.element.append(el('div', { class: 'banner-words' }, this.title_, this.text_), this.progress_, this.token_.element, el('div', { class: 'banner-buttons' }, ...this.buttons_));
    this.buttons_.forEach((button, i) => button.addEventListener('click', () => this.acts_[i]?.[1]()));
    viewer_.on(['connection', 'scene', 'path', 'watching'], () => this.refresh());
    window.setInterval(() => {
      if (viewer_.state.connection.name === 'waiting') this.refresh();
    }, 250);
    this.refresh();
  }

  private refresh(): void {
    const { connection, scene, pathPlaying, pathResult, ready } = this.viewer_.state;
    this.element.classList.toggle('waiting', ready === null);
    if (connection.name !== 'open') return this.connection();
    if (scene?.state === 'loading') return this.loading(displayName(scene.name), scene.what, scene.share);
    if (scene === null) return this.show('Connected', 'waiting for the scene', null);
    if (!pathPlaying && pathResult !== null && pathResult !== this.closedResult_) return this.result(pathResult);
    const { active, askedBy } = this.viewer_.watching;
    if (active) return this.watching();
    if (askedBy !== null) return this.asked(askedBy);
    this.element.hidden = true;
  }

  private watching(): void {
    const text = 'Camera and settings are theirs; the JPEG quality is yours.';
    const asked = this.viewer_.watching.asks;
    const ask: Act = [asked ? 'Asked to drive' : 'Ask to drive', () => this.viewer_.seat.askToDrive()];
    this.show('You watch a view of somebody else', text, null, ['View of my own', () => this.viewer_.seat.leave()], ask);
    this.buttons_[1]!.disabled = asked;
  }

  private asked(viewer: number): void {
    const answer = (handOver: boolean) => () => this.viewer_.seat.answer(handOver);
    const text = 'Who drives moves the camera and changes settings. You would watch, and may ask for it back.';
    this.show(`Viewer ${viewer} wants to drive`, text, null, ['Hand over', answer(true)], ['Keep driving', answer(false)]);
  }

  private connection(): void {
    const state = this.viewer_.state.connection;
    const first = this.viewer_.state.hello === null;
    if (state.name === 'stopped') {
      this.show('Not connected', state.reason, null);
      this.token_.element.hidden = !state.wantsToken;
      return;
    }
    if (state.name === 'open') return;
    const { refusal } = state;
    if (refusal !== null) {
      const wait = state.name === 'waiting' ? this.wait(state.retryAt) : 'trying again now';
      const sentence = `T${wait.slice(1)}`;
      const text = refusal.advice === '' ? wait : `${refusal.advice} ${sentence}`;
      return this.show(refusal.title, text, null, ['Try now', () => this.viewer_.connect()]);
    }
    if (state.name === 'connecting')
      return this.show(first ? 'Connecting' : 'Connection lost', first ? 'to the server' : 'trying again now', null);
    const reason = state.reason === '' ? '' : ` (${state.reason})`;
    const title = first ? 'The server does not answer' : 'Connection lost';
    this.show(title + reason, this.wait(state.retryAt), null, ['Try now', () => this.viewer_.connect()]);
  }

  private readonly wait = (retryAt: number): string =>
    `trying again in ${Math.max(0, Math.ceil((retryAt - performance.now()) / 1000))} s`;

  private loading(name: string, what: string, share: number): void {
    this.show(`Loading ${name}`, what, share);
  }

  private result(result: PathResult): void {
    const text =
      `${result.frames} frames · ${compact(result.msMedian)} ms median · ${compact(result.msP95)} ms 95 % · ` +
      `${compact(result.fpsMean)} /s mean · ${compact(result.fpsMin)} /s least`;
    this.show('Benchmark path ended', text, null, [
      'Close',
      () => {
        this.closedResult_ = result;
        this.refresh();
      },
    ]);
  }

  private show(title: string, text: string, share: number | null, ...acts: readonly Act[]): void {
    if (this.element.hidden || this.title_.textContent !== title) this.announce_(`${title}. ${text}`);
    this.token_.element.hidden = true;
    setText(this.title_, title);
    setText(this.text_, text);
    this.progress_.hidden = share === null;
    this.progress_.value = share ?? 0;
    this.acts_ = acts;
    this.buttons_.forEach((button, i) => {
      const label = acts[i]?.[0] ?? '';
      button.hidden = label === '';
      button.disabled = false;
      if (button.textContent !== label) button.replaceChildren(label === 'Close' ? icon('close') : '', label);
    });
    this.element.hidden = false;
  }
}
