// Own files: dropped on the page or chosen, sent to the server with progress, and opened.

import { el, icon, setText } from '../page/dom.js';
import { authorization } from '../wire/token.js';
import { isObject } from '../wire/fields.js';
import type { Viewer } from '../viewer.js';
import { chosenFiles, droppedFiles, withArchivesOpened } from './dropped_files.js';
import { brokenText, progressText, type Sent } from './upload_progress.js';
import { chooseUpload, sceneToOpen, uploadHead, type UploadLimits } from './upload_files.js';
import { ZipError } from './zip.js';
import './upload_view.css';

const ADDRESS = 'uploads';

export class UploadView {
  readonly element: HTMLElement;
  private readonly text_ = el('span', { class: 'upload-text' });
  private readonly progress_ = el('progress', { max: 1, value: 0, 'aria-label': 'Upload' });
  private readonly field_ = el('input', { type: 'file', multiple: true, hidden: true, 'aria-label': 'Own files' });
  private readonly drop_ = el('div', { class: 'drop-frame', hidden: true }, 'Drop a glTF, GLB or OBJ, its folder or zip, or an HDR');
  private readonly card_: HTMLElement;
  private readonly again_ = el('button', { type: 'button', class: 'wide-button', hidden: true }, 'Send again');
  private broken_: { readonly body: Blob; readonly scene: string } | null = null; // to be sent again
  private stopped_ = false; // by the viewer
  private request_: XMLHttpRequest | null = null;

  constructor(
    private readonly viewer_: Viewer,
    private readonly announce_: (text: string) => void,
  ) {
    const cancel = el('button', { type: 'button', class: 'ghost', 'aria-label': 'Stop the upload' }, icon('close'));
    cancel.addEventListener('click', () => this.stop());
    this.again_.addEventListener('click', () => this.sendAgain());
    this.card_ = el('div', { class: 'upload-card', hidden: true }, this.text_, cancel, this.progress_, this.again_);
    this.element = el('div', {}, this.drop_, this.card_, this.field_);
    this.field_.addEventListener('change', () => {
      if (this.field_.files !== null) void this.bring(chosenFiles(this.field_.files));
      this.field_.value = '';
    });
    window.addEventListener('dragover', (event) => this.over(event));
    window.addEventListener('dragleave', (event) => {
      if (event.relatedTarget === null) this.drop_.hidden = true;
    });
    window.addEventListener('drop', (event) => void this.dropped(event));
  }

  /** Asks for files, for who does not drag. */
  choose(): void {
    this.field_.click();
  }

  private over(event: DragEvent): void {
    if (!(event.dataTransfer?.types.includes('Files') ?? false)) return;
    event.preventDefault();
    this.drop_.hidden = false;
  }

  private async dropped(event: DragEvent): Promise<void> {
    this.drop_.hidden = true;
    if (event.dataTransfer === null || !event.dataTransfer.types.includes('Files')) return;
    event.preventDefault(); // else the browser leaves the page for the file
    await this.bring(await droppedFiles(event.dataTransfer));
  }

  private async bring(brought: ReturnType<typeof chosenFiles>): Promise<void> {
    const say = (text: string): void => this.viewer_.onMessage({ kind: 'error', text });
    if (this.viewer_.seat.drivenByOthers() || brought.length === 0) return;
    try {
      await this.upload(brought, say);
    } catch (error) {
      const what = error instanceof ZipError ? 'This archive cannot be read' : 'These files cannot be read';
      say(`${what}: ${error instanceof Error ? error.message : String(error)}.`);
    }
  }

  private async upload(brought: ReturnType<typeof chosenFiles>, say: (text: string) => void): Promise<void> {
    const all = await withArchivesOpened(brought);
    if (this.request_ !== null) return say('An upload is under way. Wait for it, or stop it.');
    const choice = chooseUpload(all, await this.limits());
    if (choice.name === 'refused') return say(choice.why);
    if (choice.leftOut > 0)
      this.viewer_.onMessage({ kind: 'notice', text: `${choice.leftOut} of ${all.length} files belong to no scene and stay here.` });
    const { files, scene } = choice;
    const parts: BlobPart[] = [uploadHead(scene.path, files) as BlobPart];
    for (const file of files) parts.push(await file.open()); // one after another: the archive's packed bytes are on disk
    if (this.request_ !== null) return say('An upload is under way. Wait for it, or stop it.');
    const body = new Blob(parts);
    this.send(body, scene.path);
  }

  /** What the server takes; null where it takes nothing. */
  private async limits(): Promise<UploadLimits | null> {
    const headers = authorization();
    try {
      const answer = await fetch(ADDRESS, { headers });
      const told: unknown = answer.ok ? await answer.json() : null;
      if (!isObject(told)) return null;
      return { bytes: Number(told['bytes']), files: Number(told['files']), free: Number(told['free']) };
    } catch {
      return null;
    }
  }

  /** Ends an upload, or forgets one that broke. */
  private stop(): void {
    this.stopped_ = true;
    if (this.request_ !== null) return this.request_.abort();
    this.broken_ = null;
    this.card_.hidden = true;
  }

  private sendAgain(): void {
    const broken = this.broken_;
    if (broken !== null && this.request_ === null) this.send(broken.body, broken.scene);
  }

  private send(body: Blob, scene: string): void {
    const request = new XMLHttpRequest(); // fetch tells nothing of what was sent
    this.request_ = request;
    request.open('POST', ADDRESS);
    for (const [name, value] of Object.entries(authorization())) request.setRequestHeader(name, value);
    const begin = performance.now();
    let sent: Sent = { loaded: 0, total: body.size, ms: 0 };
    request.upload.addEventListener('progress', ({ loaded, total }) => {
      sent = { loaded, total, ms: performance.now() - begin };
      this.show(progressText(scene, sent), sent);
    });
    request.addEventListener('loadend', () => this.ended(request, { body, scene }, sent));
    this.broken_ = null;
    this.stopped_ = false;
    this.again_.hidden = true;
    this.show(progressText(scene, sent), sent);
    this.announce_(`Uploading ${scene}.`);
    request.send(body);
  }

  private show(text: string, { loaded, total }: Sent): void {
    setText(this.text_, text);
    this.progress_.value = total > 0 ? loaded / total : 0;
    this.card_.hidden = false;
  }

  private ended(request: XMLHttpRequest, upload: { readonly body: Blob; readonly scene: string }, sent: Sent): void {
    this.request_ = null;
    const { status, responseText } = request;
    if (status === 0 && !this.stopped_) return this.broke(upload, sent);
    this.card_.hidden = true;
    if (status === 201) return this.viewer_.openScene(sceneToOpen(nameIn(responseText), this.viewer_.state.readyName));
    const why = responseText.trim();
    const text = status === 0 ? 'The upload was stopped. Nothing of it is kept.' : `The server did not take it: ${why}`;
    this.viewer_.onMessage({ kind: status === 0 ? 'notice' : 'error', text });
  }

  /** The files are still here: they can be sent once more. */
  private broke(upload: { readonly body: Blob; readonly scene: string }, sent: Sent): void {
    const text = brokenText(upload.scene, sent);
    this.broken_ = upload;
    this.again_.hidden = false;
    this.show(text, sent);
    this.announce_(text);
  }
}

function nameIn(answer: string): string {
  const told: unknown = JSON.parse(answer);
  return isObject(told) ? String(told['scene']) : '';
}
