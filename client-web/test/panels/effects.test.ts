import assert from 'node:assert/strict';
import { test } from 'node:test';
import { EffectCostModel } from '../../src/panels/effects/effect_costs.js';
import { allows, costText, effectFigures, effectRows, effectState, hasOwnSwitch, possible, sectionOf } from '../../src/panels/effects/effect_rows.js';
import type { EffectCostsMessage } from '../../src/wire/effect_costs_message.js';
import { parseMessage, type EffectReason, type SceneReady, type SettingRow } from '../../src/wire/protocol.js';

const CAMERA = { position: [0, 0, 0], forward: [0, 0, -1], up: [0, 1, 0], fieldOfView: 60 };

/** Effects as the page reads them from a scene's message. */
function effects(list: readonly object[]): SceneReady['effects'] {
  const bounds = { low: [0, 0, 0], high: [1, 1, 1] };
  const fields = { type: 'scene', name: 'x', state: 'ready', camera: CAMERA, bounds, radius: 1, effects: list.map((effect) => ({ simulated: true, ...effect })) };
  const message = parseMessage(JSON.stringify(fields));
  assert.ok(message?.type === 'scene' && message.ready !== null);
  return message.ready.effects;
}

const switchRow = (name: string, label: string): SettingRow =>
  ({ name, label, type: 'bool', default: true, effect: name, choices: [] }) as unknown as SettingRow;
const SCHEMA = [
  switchRow('shadows', 'Shadows'),
  switchRow('environment', 'Environment image'),
  { ...switchRow('aperture', 'Aperture'), type: 'float' as const, effect: 'depthOfField' },
];

test('effectRows: called for first, each with the setting that allows it', () => {
  const list = effects([
    { name: 'alphaMask', calledFor: false, because: 'no cut-out material' },
    { name: 'shadows', calledFor: true, because: '2 lights', setting: 'shadows' },
    { name: 'transparentShadows', calledFor: true, because: 'glass', setting: 'shadows', help: 'Tinted.' },
    { name: 'environment', calledFor: false, because: 'no image', setting: 'environment' },
    { name: 'depthOfField', calledFor: true, because: '', setting: 'aperture' },
  ]);
  assert.deepEqual(
    effectRows(list, SCHEMA).map((row) => [row.label, row.setting?.name ?? null]),
    [
      ['Shadows', 'shadows'],
      ['Transparent shadows', 'shadows'],
      ['Depth of field', 'aperture'],
      ['Alpha mask', null],
      ['Environment image', 'environment'],
    ],
  );
});

test('effectRows: what belongs to an effect stands with it, and nothing stands twice', () => {
  const number = (name: string, effect: string): SettingRow =>
    ({ name, label: name, type: 'int', default: 1, effect, choices: [] }) as unknown as SettingRow;
  const schema = [
    switchRow('shadows', 'Shadows'),
    number('shadowSamples', 'shadows'),
    switchRow('sun', 'Sun'),
    number('sunSize', 'sun'),
    { ...switchRow('integrator', 'Integrator'), type: 'choice' as const, default: 'interactive', effect: 'path' },
    number('maxBounces', 'path'),
    { ...switchRow('samples', 'Samples'), effect: '' },
  ];
  const list = effects([
    { name: 'shadows', calledFor: true, setting: 'shadows' },
    { name: 'transparentShadows', calledFor: true, setting: 'shadows' },
    { name: 'sun', choice: true, setting: 'sun' },
  ]);
  const rows = effectRows(list, schema);
  assert.deepEqual(
    rows.map((row) => [row.name, sectionOf(row), hasOwnSwitch(row), row.settings.map(({ name }) => name).join()]),
    [
      ['shadows', 'on', true, 'shadowSamples'],
      ['transparentShadows', 'on', false, ''],
      ['sun', 'choice', true, ''], // its rows stand in the panel Light
      ['path', 'unknown', true, 'maxBounces'], // the scene has said nothing of it
    ],
  );
  assert.equal(effectState(rows[3]!, true), '');
});

test('effectState: not called for, allowed, switched off', () => {
  const [row] = effectRows(effects([{ name: 'shadows', calledFor: true, because: '2 lights' }]), SCHEMA);
  const [idle] = effectRows(effects([{ name: 'alphaMask', calledFor: false, because: 'no cut-out material' }]), SCHEMA);
  assert.equal(effectState(row!, true), 'on: 2 lights');
  assert.equal(effectState(row!, false), 'switched off, the scene calls for it: 2 lights');
  assert.equal(effectState(idle!, true), 'off: no cut-out material');
  assert.deepEqual([true, 0.1, undefined, false, 0].map(allows), [true, true, true, false, false]);
});

test('effectState: called for, but nothing simulates it', () => {
  const fields = { name: 'skinning', calledFor: true, because: '2 skinned meshes; shown at rest', simulated: false };
  const [row] = effectRows(effects([fields]), SCHEMA);
  assert.equal(effectState(row!, true), 'not simulated: 2 skinned meshes; shown at rest');
});

test('costText: a range, and nothing finer than it', () => {
  assert.equal(costText(1.234, 1.789), 'costs 1.2 to 1.8 ms');
  assert.equal(costText(480.2, 513.7), 'costs 480 to 510 ms');
  assert.equal(costText(-6269, 513), 'costs less than 7000 ms, or nothing');
  assert.equal(costText(-3.2, -1.1), 'saves 1 to 3 ms');
  assert.equal(costText(0, 0), '', 'the same frames: nothing was measured');
});

test('effectState: the viewer chooses', () => {
  const all = effects([{ name: 'fog', calledFor: false, choice: true, because: 'the viewer chooses' }, { name: 'shadows', calledFor: true }]);
  const [shadows, fog] = effectRows(all, SCHEMA);
  assert.equal(shadows!.name, 'shadows', 'what the scene calls for stands first');
  assert.deepEqual([effectState(fog!, true), effectState(fog!, false)], ['on: you chose it', 'off: yours to choose']);
  assert.ok(possible(fog!));
});

test('effectFigures: rays of the kinds that one effect shoots alone, and the measured cost', () => {
  const reasons: readonly EffectReason[] = effects(
    ['shadows', 'ambientOcclusion', 'textures'].map((name) => ({ name, calledFor: true, because: '' })),
  );
  const [shadows, occlusion, textures] = effectRows(reasons, SCHEMA);
  const rays = { shadow: 2_310_400, ambient_occlusion: 1 };
  assert.equal(effectFigures(shadows!, rays, null), '2.31 M rays');
  assert.equal(effectFigures(occlusion!, rays, null), '1 ray');
  assert.equal(effectFigures(occlusion!, {}, null), '');
  assert.equal(effectFigures(shadows!, null, null), '');
  const cost = { name: 'textures', onMs: 121.4, offMs: 121.5, lowMs: -0.42, highMs: 0.31, raysOn: 7, raysOff: 12 };
  assert.equal(effectFigures(textures!, rays, cost), 'costs less than 0.5 ms, or nothing \u00b7 5 rays fewer');
  assert.equal(
    effectFigures(textures!, null, { name: 'textures', onMs: 3, offMs: 1, lowMs: 1.6, highMs: 2.8, raysOn: 30, raysOff: 10 }, 2.5),
    'costs 4 to 7 ms \u00b7 50 rays more',
    'for the pixels of the view',
  );
});

function costs(text: object): EffectCostsMessage {
  const message = parseMessage(JSON.stringify({ type: 'effectCosts', ...text }));
  assert.ok(message?.type === 'effectCosts');
  return message;
}
const READY = { state: 'ready', scene: 'glass', device: 'embree', width: 320, height: 180 };

test('effectCosts: read from the server, another state is refused', () => {
  const row = { name: 'shadows', onMs: 2, offMs: 1, lowMs: 0.5, highMs: 1.5, raysOn: 20, raysOff: 10 };
  assert.deepEqual(costs({ ...READY, rows: [row] }), { type: 'effectCosts', ...READY, scale: 1, rows: [row] });
  assert.deepEqual(costs({ ...READY, scale: 4.5, rows: [] }), { type: 'effectCosts', ...READY, scale: 4.5, rows: [] });
  assert.deepEqual(costs({ state: 'measuring', share: 0.25 }), {
    type: 'effectCosts',
    state: 'measuring',
    share: 0.25,
  });
  assert.deepEqual(costs({ state: 'failed', what: 'device lost' }), {
    type: 'effectCosts',
    state: 'failed',
    what: 'device lost',
  });
  assert.throws(() => costs({ state: 'done' }), /effectCosts\.state: done/);
});

test('EffectCostModel: measuring, ready, refused; late answers of another scene say nothing', () => {
  let changes = 0;
  const model = new EffectCostModel(() => (changes += 1));
  const name = (): string => model.state.name;
  model.answered(costs({ state: 'measuring', share: 0.5 }), 'glass');
  assert.equal(name(), 'unknown', 'nobody asked');
  model.asked();
  model.answered(costs({ state: 'measuring', share: 0.5 }), 'glass');
  assert.deepEqual(model.state, { name: 'measuring', share: 0.5 });
  model.answered(costs(READY), 'glass');
  assert.equal(name(), 'ready');
  model.disconnected();
  assert.equal(name(), 'ready');
  model.sceneChanged();
  model.answered(costs(READY), 'cornell');
  assert.equal(name(), 'unknown');
  model.asked();
  model.disconnected();
  assert.equal(name(), 'unknown');
  model.asked();
  model.answered(costs(READY), 'cornell');
  assert.deepEqual(model.state, { name: 'failed', message: 'The server measured another scene: glass.' });
  model.asked();
  model.answered({ type: 'effectCosts', state: 'failed', what: 'device lost' }, 'glass');
  assert.deepEqual(model.state, { name: 'failed', message: 'device lost' });
  model.refused('effectCosts: busy');
  assert.deepEqual(model.state, { name: 'failed', message: 'effectCosts: busy' });
  assert.equal(changes, 11);
});
