import assert from 'node:assert/strict';
import { test } from 'node:test';
import { poolRows, poolTitle } from '../../src/panels/statistics/pool_rows.js';
import { parseMessage, type Stats } from '../../src/wire/protocol.js';

function told(fields: object): Stats {
  const message = parseMessage(JSON.stringify({ type: 'stats', ...fields }));
  assert.equal(message?.type, 'stats');
  return message.type === 'stats' ? message : assert.fail();
}

const NODES = [
  { device: 'node:3', name: 'box', hardware: 'embree', state: 'ready', refused: '', roundTripMs: 0.5, mraysPerSecond: 12, tiles: 40 },
  { device: 'node:4', name: 'bax', hardware: 'vulkan:0', state: 'fetching the scene', refused: '', tiles: 0 },
  { device: '', name: 'old', hardware: 'embree', state: 'refused', refused: 'is of another build', tiles: 0 },
];
const PARTS = [{ device: 'node:3', part: 'works', reason: '', mraysPerSecond: 12, share: 0.25, idleShare: 0 }];

test('pool: each node with its share, rate and round trip; who is refused is told why', () => {
  const stats = told({ pool: { broker: 'nats://a:4222', connected: true, nodes: NODES }, parts: PARTS });
  assert.ok(stats.pool !== null);
  assert.equal(poolTitle(stats.pool), 'Pool: 2 nodes');
  const rows = poolRows(stats.pool, stats.parts).map(({ label, text, note }) => `${label} | ${text} | ${note}`);
  assert.deepEqual(rows, [
    'node:3 | 25 % | box · 12.0 Mrays/s · 0.5 ms there and back · embree',
    'node:4 | fetching the scene | bax · vulkan:0',
    'old | refused | is of another build',
  ]);
});

test('pool: without a line, without nodes, without a pool', () => {
  assert.equal(poolTitle(told({ pool: { broker: 'nats://a:4222', connected: false } }).pool!), 'Pool: no line to nats://a:4222');
  assert.equal(poolTitle(told({ pool: { connected: true, nodes: [] } }).pool!), 'Pool: no nodes');
  assert.equal(poolTitle(told({ pool: { connected: true, nodes: NODES.slice(0, 1) } }).pool!), 'Pool: 1 node');
  assert.equal(told({}).pool, null);
});
