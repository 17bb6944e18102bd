// Files and folders that were dropped on the page, or chosen, with their paths.

import type { NamedFile } from './upload_files.js';

export interface BroughtFile extends NamedFile {
  readonly file: File;
}

const MOST = 20_000; // entries; a disk dropped by mistake ends there

const brought = (file: File, path: string): BroughtFile => ({ path, bytes: file.size, file });

/** Of a field; a folder's files have their path in it. */
export const chosenFiles = (list: FileList): readonly BroughtFile[] =>
  [...list].map((file) => brought(file, file.webkitRelativePath === '' ? file.name : file.webkitRelativePath));

/** To be called while the event lasts; folders are read afterwards. */
export function droppedFiles(transfer: DataTransfer): Promise<readonly BroughtFile[]> {
  const entries = [...transfer.items].map((item) => item.webkitGetAsEntry()).filter((entry) => entry !== null);
  const plain = chosenFiles(transfer.files);
  return entries.length === 0 ? Promise.resolve(plain) : walk(entries);
}

async function walk(roots: readonly FileSystemEntry[]): Promise<readonly BroughtFile[]> {
  const found: BroughtFile[] = [];
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
