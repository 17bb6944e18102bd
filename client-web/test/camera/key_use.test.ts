import assert from 'node:assert/strict';
import test from 'node:test';
import { keyUse, type KeyPress } from '../../src/camera/key_use.js';

const press = (code: string, more: Partial<KeyPress> = {}): KeyPress => ({
  code,
  plain: true,
  control: 'none',
  flying: false,
  ...more,
});

test('on the picture keys fly or are shortcuts of the page', () => {
  assert.equal(keyUse(press('KeyW')), 'flight');
  assert.equal(keyUse(press('Space')), 'flight');
  assert.equal(keyUse(press('KeyR')), 'page');
  assert.equal(keyUse(press('KeyW', { plain: false })), 'control');
});

test('a button has Space and Enter, unless another key flies', () => {
  for (const code of ['Space', 'Enter', 'NumpadEnter']) {
    assert.equal(keyUse(press(code, { control: 'button' })), 'control');
    assert.equal(keyUse(press(code, { control: 'button', flying: true })), 'flight');
  }
  assert.equal(keyUse(press('KeyW', { control: 'button' })), 'flight');
  assert.equal(keyUse(press('Enter')), 'page');
});

test('a slider keeps its arrows, words and numbers keep all but function keys', () => {
  assert.equal(keyUse(press('ArrowLeft', { control: 'slider', flying: true })), 'control');
  assert.equal(keyUse(press('KeyW', { control: 'slider' })), 'flight');
  assert.equal(keyUse(press('KeyW', { control: 'text' })), 'control');
  assert.equal(keyUse(press('F1', { control: 'text' })), 'page');
});

test('a dialog and a menu keep every key, F1 and F2 too', () => {
  for (const code of ['KeyW', 'F1', 'F2', 'Escape']) assert.equal(keyUse(press(code, { control: 'dialog' })), 'control');
});
