import assert from 'node:assert/strict';
import { test } from 'node:test';
import { MOST_VIEWS, nameFor, savedViews, withSaved, type SavedView } from '../src/views/saved_views.js';

const view = (number: number): SavedView => ({ name: `A ${number}`, fragment: `at=${number}`, picture: 'data:image/jpeg;base64,' });

test('views are kept in order, the newest first, each place once', () => {
  let views: readonly SavedView[] = [];
  for (let i = 0; i < MOST_VIEWS + 5; i += 1) views = withSaved(views, view(i));
  assert.equal(views.length, MOST_VIEWS);
  assert.equal(views[0]!.name, `A ${MOST_VIEWS + 4}`);
  views = withSaved(views, { ...view(MOST_VIEWS), name: 'again' });
  assert.equal(views.length, MOST_VIEWS);
  assert.equal(views[0]!.name, 'again');
  assert.deepEqual(savedViews(JSON.stringify(views)), views);
});

test('what the browser kept may be anything', () => {
  for (const text of [null, '', '{', '{}', '[1]', '[null]', '[{"name":1,"fragment":"","picture":""}]']) {
    assert.deepEqual(savedViews(text), [], String(text));
  }
  const evil = JSON.stringify([{ ...view(1), picture: 'https://elsewhere.example/x.png' }]);
  assert.equal(savedViews(evil)[0]!.picture, '');
});

test('a name has a number of its own', () => {
  assert.equal(nameFor('A', []), 'A 1');
  assert.equal(nameFor('A', [view(1), view(2), view(4)]), 'A 3');
});
