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
  assert.equal(own.begin('own', 'k'), null);
  assert.equal(own.active, false);
  assert.equal(own.maySet(['exposure']), true);
  assert.equal(own.looked, 'own');
});

/** A page that came by a link to view 0123, which somebody else drives. */
function watcher(): Watching {
  const watching = new Watching('0123');
  assert.deepEqual(watching.begin('own', 'k'), { view: '0123', key: '' });
  return watching;
}

test('Watching: nothing that drives is sent from the question on', () => {
  const watching = watcher();
  assert.equal(watching.active, true);
  assert.equal(watching.awaits, true);
  assert.equal(watching.maySet(['jpegQuality']), true);
  assert.equal(watching.maySet(['jpegQuality', 'exposure']), false);
  assert.equal(watching.answered('0123', false), 'none');
  assert.equal(watching.active, true);
  assert.equal(watching.awaits, false);
});

test('Watching: who drives from now on is told so once, and has its view after a reconnect', () => {
  const watching = watcher();
  watching.answered('0123', false);
  assert.equal(watching.answered('0123', true), 'given');
  assert.equal(watching.active, false);
  assert.equal(watching.answered('0123', true), 'none');
  assert.deepEqual(watching.begin('other', 'k2'), { view: '0123', key: 'k' });
  assert.equal(watching.active, true, 'until the server has answered');
  assert.equal(watching.answered('0123', true), 'resumed');
});

test('Watching: a view that nobody looks at is driven from where it was left', () => {
  assert.equal(watcher().answered('0123', true), 'found');
});

test('Watching: a view that is not there, or was left, is not asked for again', () => {
  const gone = watcher();
  assert.equal(gone.refused(), false);
  assert.equal(gone.active, false);
  assert.equal(gone.looked, 'own');
  const left = watcher();
  left.answered('0123', false);
  left.leave();
  assert.equal(left.active, true, 'until the server has answered');
  assert.equal(left.answered('mine', true), 'own');
  assert.deepEqual(left.begin('other', 'k2'), { view: 'mine', key: 'k' });
});

test('Watching: after a lost connection the view of one\u2019s own is asked for with its key, and its loss needs no words', () => {
  const own = new Watching(null);
  own.begin('a', 'k1');
  assert.deepEqual(own.begin('b', 'k2'), { view: 'a', key: 'k1' });
  assert.equal(own.refused(), true);
  assert.deepEqual(own.begin('c', 'k3'), { view: 'b', key: 'k2' });
  assert.equal(own.answered('b', false), 'none', 'another one drives it meanwhile');
  assert.deepEqual(own.begin('d', 'k4'), { view: 'b', key: 'k3' });
  assert.equal(own.refused(), false, 'who watched is told');
});

test('Watching: driving is asked for, refused, given and given away', () => {
  const watching = watcher();
  watching.answered('0123', false);
  watching.ask();
  assert.equal(watching.asks, true);
  assert.equal(watching.answered('0123', false), 'kept');
  assert.equal(watching.asks, false);
  watching.ask();
  watching.setAskedBy(7);
  assert.equal(watching.askedBy, null, 'who watches is asked by nobody');
  assert.equal(watching.answered('0123', true), 'given');
  watching.setAskedBy(7);
  assert.equal(watching.askedBy, 7);
  assert.equal(watching.answered('0123', false), 'handedOver');
  assert.equal(watching.askedBy, null);
  assert.equal(watching.active, true);
});

test('protocol: who drives, and a picture that is smaller than asked for', () => {
  const camera = { position: [1, 2, 3], forward: [0, 0, -1], up: [0, 1, 0], fieldOfView: 50 };
  assert.deepEqual(parseMessage(JSON.stringify({ type: 'watching', view: 'ab', drives: true, camera })), {
    type: 'watching',
    view: 'ab',
    drives: true,
    camera,
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
