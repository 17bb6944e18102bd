import assert from 'node:assert/strict';
import { test } from 'node:test';
import { sizeText } from '../src/picture/resolution.js';
import { parseMessage } from '../src/wire/protocol.js';
import { viewOf, Watching, withoutView, withView } from '../src/watching.js';

test('Watching: the link to a view names it and bears no token', () => {
  assert.equal(withView('http://a/b/?x=1&view=old#token=secret', '01ef'), 'http://a/b/?x=1&view=01ef');
  assert.equal(viewOf(withView('http://a/', '01ef')), '01ef');
});

test('Watching: the address says which view; without one the page drives its own', () => {
  assert.equal(viewOf('http://a/b/?view=0123&x=1#token=t'), '0123');
  assert.equal(viewOf('http://a/?view='), null);
  assert.equal(viewOf('http://a/#view=0123'), null);
  assert.equal(withoutView('http://a/b/?view=0123&x=1#token=t'), 'http://a/b/?x=1#token=t');
  const own = new Watching(null);
  assert.equal(own.begin(), null);
  assert.equal(own.active, false);
  assert.equal(own.maySet(['exposure']), true);
});

test('Watching: nothing that drives is sent from the question on', () => {
  const watching = new Watching('0123');
  assert.equal(watching.begin(), '0123');
  assert.equal(watching.active, true);
  assert.equal(watching.maySet(['jpegQuality']), true);
  assert.equal(watching.maySet(['jpegQuality', 'exposure']), false);
  assert.equal(watching.answered(false), false);
  assert.equal(watching.active, true);
});

test('Watching: who drives from now on is told so once', () => {
  const watching = new Watching('0123');
  watching.begin();
  watching.answered(false);
  assert.equal(watching.answered(true), true);
  assert.equal(watching.active, false);
  assert.equal(watching.answered(true), false);
  assert.equal(watching.begin(), '0123', 'after a reconnect it watches again');
});

test('Watching: a view that is not there, or was left, is not asked for again', () => {
  const gone = new Watching('0123');
  gone.begin();
  gone.giveUp();
  assert.equal(gone.active, false);
  assert.equal(gone.begin(), null);
  const left = new Watching('0123');
  left.begin();
  left.leave();
  assert.equal(left.active, true, 'until the server has answered');
  assert.equal(left.answered(true), true);
  assert.equal(left.begin(), null);
});

test('protocol: who drives, and a picture that is smaller than asked for', () => {
  const camera = { position: [1, 2, 3], forward: [0, 0, -1], up: [0, 1, 0], fieldOfView: 50 };
  assert.deepEqual(parseMessage(JSON.stringify({ type: 'watching', view: 'ab', drives: true, camera })), {
    type: 'watching',
    view: 'ab',
    drives: true,
    camera,
    inputId: null,
  });
  assert.deepEqual(
    parseMessage('{"type":"resolution","wanted":[1920,1080],"given":[1280,720],"text":"words","inputId":3}'),
    { type: 'resolution', wanted: [1920, 1080], given: [1280, 720] },
  );
  assert.throws(() => parseMessage('{"type":"resolution","wanted":[1920],"given":[1280,720]}'), /resolution\.wanted/);
  assert.equal(sizeText({ width: 1920, height: 1080 }, null), '1920 × 1080 px');
  assert.equal(
    sizeText({ width: 1920, height: 1080 }, { width: 1280, height: 720 }),
    "given 1280 × 720 of 1920 × 1080 px: the server's memory for pictures is short",
  );
});
