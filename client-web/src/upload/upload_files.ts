// Which of the files that a viewer brings is the scene, what is left out, and what is sent of them. Knows no DOM.

export interface NamedFile {
  readonly path: string; // '/' separates
  readonly bytes: number;
}

export interface UploadLimits {
  readonly bytes: number;
  readonly files: number;
  readonly free: number; // bytes that the server has room for now
}

const SCENES = /\.(gltf|glb|obj)$/i;
const SURROUNDINGS = /\.(hdr|exr)$/i;
const PARTS = /\.(bin|mtl|png|jpe?g|webp|tga|bmp)$/i;

export const isSurroundings = (path: string): boolean => SURROUNDINGS.test(path);

export type UploadChoice<File extends NamedFile> =
  | { readonly name: 'refused'; readonly why: string }
  | { readonly name: 'chosen'; readonly scene: File; readonly files: readonly File[]; readonly leftOut: number };

const depthOf = (path: string): number => path.split('/').length;
const mebibytes = (bytes: number): string => `${Math.ceil(bytes / 2 ** 20)} MiB`;

/** The scene nearest to the top, glTF before OBJ; without one an image of surroundings. Hidden and other files stay. */
export function chooseUpload<File extends NamedFile>(
  all: readonly File[],
  limits: UploadLimits | null,
): UploadChoice<File> {
  const refused = (why: string): UploadChoice<File> => ({ name: 'refused', why });
  if (limits === null) return refused('This server takes no files: its operator has not opened a folder for them (--uploads).');
  const seen = all.filter(({ path }) => !path.split('/').some((part) => part.startsWith('.')));
  const rank = (file: File): number => depthOf(file.path) * 2 + (/\.obj$/i.test(file.path) ? 1 : 0);
  const scenes = seen.filter(({ path }) => SCENES.test(path)).sort((a, b) => rank(a) - rank(b));
  const scene = scenes[0] ?? seen.find(({ path }) => SURROUNDINGS.test(path));
  if (scene === undefined) return refused('None of these is a scene. A glTF, GLB or OBJ file is, or an HDR or EXR image around one.');
  const parts = ({ path }: File): boolean => SCENES.test(path) || SURROUNDINGS.test(path) || PARTS.test(path);
  const files = isSurroundings(scene.path) ? [scene] : seen.filter(parts);
  if (files.length > limits.files)
    return refused(`These are ${files.length} files; this server takes at most ${limits.files}.`);
  const bytes = files.reduce((sum, file) => sum + file.bytes, 0);
  if (bytes > limits.bytes) return refused(`These are ${mebibytes(bytes)}; this server takes at most ${mebibytes(limits.bytes)}.`);
  return { name: 'chosen', scene, files, leftOut: all.length - files.length };
}

/** What comes before the files' bytes: the length of the list, little-endian, and the list. */
export function uploadHead(scene: string, files: readonly NamedFile[]): Uint8Array {
  const list = new TextEncoder().encode(
    JSON.stringify({ scene, files: files.map(({ path, bytes }) => ({ path, bytes })) }),
  );
  const head = new Uint8Array(4 + list.length);
  new DataView(head.buffer).setUint32(0, list.length, true);
  head.set(list, 4);
  return head;
}

/** The scene to ask for: surroundings go around the one that is shown. */
export function sceneToOpen(uploaded: string, shown: string): string {
  if (!isSurroundings(uploaded)) return uploaded;
  return `${shown.replace(/\+upload\/.*$/, '')}+${uploaded}`;
}

/** Names of uploads are offered to nobody, and there all the same. */
export const isUploaded = (scene: string): boolean => /(^|\+)upload\/[0-9a-f]{32}\//.test(scene);
