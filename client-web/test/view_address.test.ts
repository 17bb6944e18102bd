import assert from 'node:assert/strict';
import { test } from 'node:test';
import { fragmentOf, settingValues, viewOfFragment, type AddressedView } from '../src/page/view_address.js';
import type { SettingRow } from '../src/wire/protocol.js';

const VIEW: AddressedView = {
  scene: 'my scene/a&b.glb',
  camera: { position: [0.5, -2, 1e-5], forward: [0, 0, -1], up: [0, 1, 0], fieldOfView: 42.5 },
  settings: { exposure: '0.5', toneCurve: 'a=b' },
};

test('a view comes back from its fragment', () => {
  assert.deepEqual(viewOfFragment(`#${fragmentOf(VIEW)}`), VIEW);
  assert.equal(fragmentOf({ scene: '', camera: null, settings: {} }), '');
  assert.deepEqual(viewOfFragment(''), { scene: '', camera: null, settings: {} });
});

test('a camera that is none is left out, one that leans is set right', () => {
  const camera = (fragment: string): AddressedView['camera'] => viewOfFragment(fragment).camera;
  const bad = ['at=1,2&look=0,0,1', 'at=1,2,3&look=0,0,0', 'at=1,2,x&look=0,0,1', 'at=1,2,3&look=0,1,0&up=0,2,0'];
  for (const fragment of [...bad, 'at=1,2,3&look=0,0,1&fov=200', 'at=1,2,3,4&look=0,0,1', 'at=1,,3&look=0,0,1'])
    assert.equal(camera(fragment), null, fragment);
  const leaning = camera('at=1,2,3&look=0,0,-2&up=0,3,1&fov=60');
  assert.deepEqual(leaning?.forward, [0, 0, -1]);
  assert.deepEqual(leaning?.up, [0, 1, 0]);
});

test('settings get the type that the table says, and those out of range or unknown are left out', () => {
  const row = (more: Partial<SettingRow>): SettingRow => ({ low: 0, high: 0, choices: [], ...more }) as SettingRow;
  const rows = [
    row({ name: 'shadows', type: 'bool' }),
    row({ name: 'exposure', type: 'float', low: -10, high: 10 }),
    row({ name: 'device', type: 'choice', choices: ['auto', 'embree'] }),
  ];
  const texts = { shadows: 'off', exposure: '0.5', device: 'embree', nothing: '1' };
  assert.deepEqual(settingValues(rows, texts), { shadows: false, exposure: 0.5, device: 'embree' });
  assert.deepEqual(settingValues(rows, { shadows: '1', exposure: '11', device: 'moon' }), {});
  assert.deepEqual(settingValues(rows, { exposure: '' }), {});
});
