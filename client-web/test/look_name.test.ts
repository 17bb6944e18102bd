import assert from 'node:assert/strict';
import { test } from 'node:test';
import { lookName, sceneOfLook } from '../src/page/look_name.js';
import { Restoring } from '../src/reconnect.js';

test('a scene in a look belongs to the name on offer that it begins with', () => {
  const offered = ['shoe.glb#beach', 'shoe.glb', 'shoe', 'a#b'];
  for (const name of ['shoe.glb', 'shoe.glb#beach', 'shoe.glb#street', 'shoe.glb#a#b'])
    assert.equal(sceneOfLook(name, offered), 'shoe.glb', name);
  assert.equal(sceneOfLook('a#b#c', offered), 'a#b');
  assert.equal(sceneOfLook('gone#b', offered), 'gone#b');
});

test('a look is named where its name is its alone, else numbered', () => {
  const looks = ['beach', 'street', 'beach', ''];
  const names = looks.map((_, number) => lookName('shoe', looks, number));
  assert.deepEqual(names, ['shoe#beach', 'shoe#street', 'shoe#2', 'shoe#3']);
});

test('after a reconnect a look of a scene on offer is asked for, another scene is not', () => {
  const own = { type: 'scene', name: 'first', state: 'ready', what: '', share: 1, ready: null } as const;
  for (const [name, ask] of [['first#beach', 'first#beach'], ['gone#beach', null]] as const) {
    const restoring = new Restoring();
    restoring.begin(name);
    assert.equal(restoring.step(own, ['first', 'second']).ask, ask);
  }
});
