// Makes docs/reference/settings.md of the table of settings, as the program tells it.
// settings_page.mjs PROGRAM          writes the page
// settings_page.mjs PROGRAM --check  says whether it is up to date; the last line is `N passed, N failed`

import { execFileSync } from 'node:child_process';
import { readFileSync, writeFileSync } from 'node:fs';
import { fileURLToPath } from 'node:url';

const WIDTH = 100;
const page = fileURLToPath(new URL('../docs/reference/settings.md', import.meta.url));
const [program, check] = process.argv.slice(2);
const rows = JSON.parse(execFileSync(program, ['inspect', '--settings'], { encoding: 'utf8' }));

const PRICES = {
  up: 'Higher is nearer to exact and costs more.',
  down: 'Lower is nearer to exact and costs more.',
  on: 'On is nearer to exact and costs more.',
  off: 'Off is nearer to exact and costs more.',
};

function fill(text, indent = '') {
  const lines = [''];
  for (const word of text.split(' ')) {
    const line = lines.at(-1);
    if (line !== '' && indent.length + line.length + 1 + word.length > WIDTH) lines.push(word);
    else lines[lines.length - 1] = line === '' ? word : `${line} ${word}`;
  }
  return lines.map((line) => indent + line).join('\n');
}

function shown(value) {
  if (typeof value === 'boolean') return value ? 'on' : 'off';
  return typeof value === 'number' ? String(Number(value.toPrecision(6))) : value;
}

const ACTS = {
  display: 'A change keeps the samples.',
  command: 'For commands; a viewer does not send it.',
};

/** What `--set` takes: the choices, or the range with its unit. */
function allowed({ type, choices, low, high, unit }) {
  if (type === 'bool') return 'on or off';
  if (type === 'choice') return choices.map((choice) => `\`${choice}\``).join(', ');
  const kind = type === 'int' ? 'whole numbers, ' : '';
  return `${kind}${shown(low)} to ${shown(high)}${unit === '' ? '' : ` ${unit}`}`;
}

function entry(row) {
  const facts = [`Default ${shown(row.default)}; ${allowed(row)}.`, row.help, PRICES[row.price] ?? '', ACTS[row.acts] ?? ''];
  return `### ${row.name}\n\n${fill(facts.filter((fact) => fact !== '').join(' '))}\n`;
}

const groups = new Map();
for (const row of rows) groups.set(row.group, [...(groups.get(row.group) ?? []), row]);
const title = (group) => group.charAt(0).toUpperCase() + group.slice(1);
const intro = fill(
  'Made by `tools/settings_page.mjs` from `shaders/kernel/settings_table.glsl`: change the table, not this page. ' +
    'The names are those of `--set NAME=VALUE`, of the message `settings` and of the form in the page.',
);
const text = `# Settings\n\n${intro}\n\n${[...groups]
  .map(([group, list]) => `## ${title(group)}\n\n${list.map(entry).join('\n')}`)
  .join('\n')}`;

if (check === '--check') {
  const same = readFileSync(page, 'utf8') === text;
  if (!same) console.log(`FAILED docs/reference/settings.md is out of date; run tools/settings_page.mjs ${program}`);
  console.log(same ? '1 passed, 0 failed' : '0 passed, 1 failed');
  process.exit(same ? 0 : 1);
}
writeFileSync(page, text);
