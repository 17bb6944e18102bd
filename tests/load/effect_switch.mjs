// How long a viewer waits for the first frame with an effect that was just switched on, for each effect that the scene calls
// for: from sending the setting to the frame that shows it. Prints figures; nothing here passes or fails.
//
//   node tests/load/effect_switch.mjs [path of heliograph] [scene] [device] [WxH] [name=value settings...]
import { Server, Viewer, sleep, until } from './viewer.mjs';

const [program = 'build/release/heliograph', scene = 'courtyard', device = 'auto', size = '1280x720', ...settings] =
  process.argv.slice(2);
const [width, height] = size.split('x').map(Number);
const SETTLED_MS = 1500; // the view before is at rest, and what it needed is compiled

/** A value as the settings take it: a number, a switch or a word. */
function valueOf(text) {
  if (text === 'true' || text === 'false') return text === 'true';
  return text !== '' && Number.isFinite(Number(text)) ? Number(text) : text;
}

/** Sends settings; milliseconds until a frame shows them. */
async function shown(viewer, values) {
  const inputId = ++viewer.inputId;
  const begin = performance.now();
  viewer.send({ type: 'settings', values, inputId });
  while (viewer.shownInputId < inputId && !viewer.problem) await sleep(1);
  if (viewer.problem) throw new Error(viewer.problem);
  return performance.now() - begin;
}

const server = await Server.start(program, scene);
try {
  await server.ready();
  const viewer = new Viewer(server.url, 0, { width, height });
  await viewer.start();
  await until(() => viewer.problem || viewer.frames > 0, 'no frame');
  if (viewer.problem) throw new Error(viewer.problem);
  const base = Object.fromEntries(settings.map((text) => text.split('=')).map(([name, text]) => [name, valueOf(text)]));
  await shown(viewer, { device, ...base });
  const waits = [];
  for (const effect of viewer.scene.effects) {
    if (!(effect.calledFor || effect.choice) || effect.setting !== effect.name) continue;
    await shown(viewer, { [effect.setting]: false });
    await sleep(SETTLED_MS);
    const same = await shown(viewer, { [effect.setting]: false }); // nothing new to make: the price of asking
    const ms = await shown(viewer, { [effect.setting]: true });
    const again = await shown(viewer, { [effect.setting]: false });
    waits.push(ms);
    console.log(`${scene} on ${device}, ${effect.name.padEnd(20)} on after ${ms.toFixed(0)} ms, off after ${again.toFixed(0)} ms` +
      ` (an equal request ${same.toFixed(0)} ms)`);
  }
  console.log(`longest: ${Math.max(...waits).toFixed(0)} ms`);
  viewer.close();
} finally {
  await server.end();
}
process.exit(0);
