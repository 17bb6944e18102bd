import assert from 'node:assert/strict';
import { test } from 'node:test';
import { paceText } from '../../src/picture/pace_text.js';
import { parseMessage, type Pace } from '../../src/wire/protocol.js';

const PACE = {
  limit: 'none',
  scale: 0.444,
  quality: 50,
  fullMs: 165.4,
  roundTripMs: 52,
  lineMs: 88.6,
  viewerMs: 120,
  bytesPerSecond: 240e3,
};

function paceOf(values: object): Pace | null {
  const message = parseMessage(JSON.stringify({ type: 'stats', ...values }));
  assert.equal(message?.type, 'stats');
  return message.type === 'stats' ? message.pace : null;
}

test('paceText: what limits is told with its figure', () => {
  const text = (limit: string): string => {
    const words = paceText(paceOf({ pace: { ...PACE, limit } })!);
    return words === null ? '' : `${words.label}: ${words.figure}. ${words.help}`;
  };
  assert.equal(text('none'), '');
  assert.equal(text('something new'), '');
  const size = 'Pictures of a moving view have 44 % of the width and JPEG quality 50';
  assert.equal(text('server'), `Server: 165 ms a full picture. ${size}: the server takes too long for larger ones.`);
  assert.equal(text('line'), `Line: 1.9 Mbit/s, 52 ms. ${size}: they queue for 89 ms on the way here.`);
  assert.equal(text('viewer'), `This computer: 120 ms late. ${size}: this computer shows them later than it could.`);
});

test('paceText: a video is told as one', () => {
  const words = paceText(paceOf({ pace: { ...PACE, limit: 'line', codec: 'vp9' } })!);
  assert.match(words?.help ?? '', /^Pictures of a moving view are a video \(VP9\), have 44 % of the width and JPEG quality 50/);
});

test('paceText: a server that says nothing of it limits nothing', () => {
  assert.equal(paceOf({}), null);
});
