// Names of scenes in one of the looks that their files offer: `NAME#LOOK`.

/** What the server calls the scene `name` without its look: the shortest name on offer that it begins with. */
export function sceneOfLook(name: string, offered: readonly string[]): string {
  const fits = offered.filter((entry) => name === entry || name.startsWith(`${entry}#`));
  return fits.reduce((shortest, entry) => (entry.length < shortest.length ? entry : shortest), fits[0] ?? name);
}

/** The scene `base` in the look of that number: by its name where that is its alone. */
export function lookName(base: string, looks: readonly string[], number: number): string {
  const name = looks[number] ?? '';
  return `${base}#${name === '' || looks.indexOf(name) !== number ? number : name}`;
}
