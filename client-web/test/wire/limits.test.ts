import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { test } from 'node:test';
import { Frames } from '../../src/frames.js';
import { StreamMeter } from '../../src/picture/stream_meter.js';
import type { Frame } from '../../src/wire/frame.js';
import * as limits from '../../src/wire/limits.js';

const source = (path: string): string => readFileSync(new URL(`../../../${path}`, import.meta.url), 'utf8');

/** LIMIT(type, NAME, value, ...) of the table, and FRAME_HEADER_BYTES. */
function serverLimits(): Map<string, number> {
  const found = new Map<string, number>();
  for (const [, name, value] of source('server/net/guard/limits.h').matchAll(/LIMIT\([\w:]+, (\w+), (\d+),/g)) {
    found.set(name!, Number(value));
  }
  const header = /FRAME_HEADER_BYTES = (\d+);/.exec(source('server/net/protocol.h'));
  return found.set('FRAME_HEADER_BYTES', Number(header?.[1]));
}

test('limits: those of the page are those of the server', () => {
  const names: Readonly<Record<keyof typeof limits, string>> = {
    HEADER_BYTES: 'FRAME_HEADER_BYTES',
    SMALLEST_SIDE: 'MIN_SIDE',
    LARGEST_SIDE: 'MAX_SIDE',
    LARGEST_PIXELS: 'MAX_PIXELS',
    LONGEST_PRESENTED_MS: 'MAX_PRESENTED_MS',
  };
  const server = serverLimits();
  for (const [name, value] of Object.entries(limits)) {
    assert.equal(value, server.get(names[name as keyof typeof limits]), name);
  }
  assert.deepEqual(Object.keys(names).sort(), Object.keys(limits).sort());
});

test('limits: a time that no server takes is not sent', () => {
  const acked: (number | null)[] = [];
  const meter = new StreamMeter();
  const frames = new Frames({ lastFrame: null, framesPresented: 0, framesDropped: 0 }, meter, {
    show: () => undefined,
    acknowledge: (_, presentedMs) => acked.push(presentedMs),
    undecodable: () => undefined,
    skipped: () => undefined,
  });
  const shown = (frameId: number, ms: number): void => {
    meter.motionToPhoton.sent(frameId, 0);
    frames.presented({ frame: { frameId, inputId: frameId } as Frame, decodeMs: 0, time: ms });
  };
  shown(1, limits.LONGEST_PRESENTED_MS);
  shown(2, limits.LONGEST_PRESENTED_MS + 1); // the computer slept meanwhile
  assert.deepEqual(acked, [limits.LONGEST_PRESENTED_MS, null]);
});
