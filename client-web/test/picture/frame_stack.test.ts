import assert from 'node:assert/strict';
import { test } from 'node:test';
import { columnOf, columnText } from '../../src/picture/frame_stack.js';
import type { FrameTimes } from '../../src/picture/frame_trace.js';

const TIMES: FrameTimes = {
  frame: {
    frameId: 12,
    inputId: 7,
    width: 640,
    height: 360,
    samples: 1,
    queueMs: 3,
    renderMs: 20,
    developMs: 2,
    encodeMs: 4,
    sendMs: 1,
  },
  input: { event: 1000, sent: 1002 },
  oneWay: 5,
  arrived: 1050,
  decoded: 1054,
  presented: 1060,
};

test('FrameStack: the parts of a column are its whole time, from the event to the screen', () => {
  const column = columnOf(TIMES);
  assert.deepEqual(column.parts, { render: 20, picture: 6, waits: 3 + 8 + 1, line: 10, page: 2 + 4 + 6 });
  assert.equal(column.total, 60);
  assert.equal(
    columnText(TIMES, column),
    'Frame 12, 640 × 360, shows input 7: 60.0 ms (tracing 20.0, developing and encoding 6.0, waiting at the server 12.0, ' +
      'on the line 10.0, this page 12.0)',
  );
});

test('FrameStack: a frame that shows no new input begins with its pass', () => {
  const times = { ...TIMES, input: null };
  const column = columnOf(times);
  assert.deepEqual(column.parts, { render: 20, picture: 6, waits: 1, line: 5, page: 10 });
  assert.match(columnText(times, column), /refines/);
});
