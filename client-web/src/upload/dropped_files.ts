// Files and folders that were dropped on the page, or chosen, with their paths.

import type { NamedFile } from './upload_files.js';
import { openZip, unpacked } from './zip.js';

export interface BroughtFile extends NamedFile {
  readonly open: () => Promise<Blob>;
}

const MOST = 20_000; // entries; a disk dropped by mistake ends there

interface PlainFile extends NamedFile {
  readonly file: File;
}

const brought = (file: File, path: string): PlainFile => ({ path, bytes: file.size, file });

/** With the files of archives instead of the archives. Throws ZipError for one that cannot be read. */
export async function withArchivesOpened(files: readonly PlainFile[]): Promise<readonly BroughtFile[]> {
  const lists = files.map(async ({ path, bytes, file }): Promise<readonly BroughtFile[]> => {
    if (!/\.zip$/i.test(path)) return [{ path, bytes, open: () => Promise.resolve(file) }];
    return (await openZip(file)).map((entry) => ({ path: entry.path, bytes: entry.bytes, open: () => unpacked(file, entry) }));
  });
  return (await Promise.all(lists)).flat();
}

/** Of a field; a folder's files have their path in it. */
export const chosenFiles = (list: FileList): readonly PlainFile[] =>
  [...list].map((file) => brought(file, file.webkitRelativePath === '' ? file.name : file.webkitRelativePath));

/** To be called while the event lasts; folders are read afterwards. */
export function droppedFiles(transfer: DataTransfer): Promise<readonly PlainFile[]> {
  const entries = [...transfer.items].map((item) => item.webkitGetAsEntry()).filter((entry) => entry !== null);
  const plain = chosenFiles(transfer.files);
  return entries.length === 0 ? Promise.resolve(plain) : walk(entries);
}

async function walk(roots: readonly FileSystemEntry[]): Promise<readonly PlainFile[]> {
  const found: PlainFile[] = [];
  const open = [...roots];
  for (let entry = open.pop(); entry !== undefined && found.length < MOST; entry = open.pop()) {
    if (isFile(entry)) found.push(brought(await fileOf(entry), entry.fullPath.replace(/^\//, '')));
    else if (entry.isDirectory) open.push(...(await contentOf(entry as FileSystemDirectoryEntry)));
  }
  return found;
}

const isFile = (entry: FileSystemEntry): entry is FileSystemFileEntry => entry.isFile;
const fileOf = (entry: FileSystemFileEntry): Promise<File> => new Promise((done, failed) => entry.file(done, failed));

/** A reader gives some hundred entries at a time, and none at the end. */
async function contentOf(folder: FileSystemDirectoryEntry): Promise<readonly FileSystemEntry[]> {
  const reader = folder.createReader();
  const all: FileSystemEntry[] = [];
  for (;;) {
    const some = await new Promise<FileSystemEntry[]>((done, failed) => reader.readEntries(done, failed));
    if (some.length === 0 || all.length > MOST) return all;
    all.push(...some);
  }
}
