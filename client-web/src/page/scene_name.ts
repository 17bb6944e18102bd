// Names of scenes as people and files like them.

/** `courtyard` as "Courtyard"; of a path only the file's name. */
export function displayName(name: string): string {
  const [scene, surroundings] = name.split(/\+upload\/[0-9a-f]+\//);
  const base = (scene ?? name).split(/[\\/]/).pop() ?? name;
  const shown = base.charAt(0).toUpperCase() + base.slice(1);
  return surroundings === undefined ? shown : `${shown} with ${surroundings}`;
}

/** Of the browser's tab; `done`: the picture has all its samples. */
export const pageTitle = (scene: string, done: boolean): string =>
  scene === '' ? 'Heliograph' : `${done ? '✓ ' : ''}${displayName(scene)} · Heliograph`;

/** Name for a saved picture; only characters that every file system takes. */
export function fileName(scene: string, width: number, height: number, samples: number, extension: string): string {
  const base = displayName(scene)
    .replace(/\.[a-z]+$/i, '')
    .toLowerCase()
    .replace(/[^a-z0-9_-]+/g, '-');
  return `heliograph-${base || 'picture'}-${width}x${height}-${samples}spp.${extension}`;
}

/** `ambientOcclusion` as "ambient occlusion". */
export const spacedWords = (name: string): string =>
  name.replace(/([a-z])([A-Z])/g, (_, a: string, b: string) => `${a} ${b.toLowerCase()}`);
