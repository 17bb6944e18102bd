import assert from 'node:assert/strict';
import { test } from 'node:test';
import { forecastText, refinedText } from '../../src/picture/forecast_text.js';
import { parseMessage, type Forecast } from '../../src/wire/protocol.js';

const FORECAST = {
  plateau: false,
  steps: [
    { error: 0.02, samples: 30, seconds: 4.2 },
    { error: 0.01, samples: 120, seconds: 16.4 },
    { error: 0.005, samples: 4821.2, seconds: 640 },
  ],
};

function told(forecast: unknown): Forecast | null {
  const message = parseMessage(JSON.stringify({ type: 'stats', forecast }));
  assert.equal(message?.type, 'stats');
  return message.type === 'stats' ? message.forecast : null;
}

test('forecastText: what comes with the samples asked for', () => {
  const forecast = told(FORECAST);
  assert.equal(forecastText(forecast, true, 256), '2 % in 4 s · 1 % in 16 s');
  assert.equal(forecastText(forecast, true, 64), '2 % in 4 s');
  assert.equal(forecastText(forecast, true, 0), '2 % in 4 s · 1 % in 16 s');
});

test('forecastText: what more samples would bring', () => {
  const forecast = told(FORECAST);
  assert.equal(forecastText(forecast, false, 64), '1 % would take 120 samples');
  assert.equal(forecastText(forecast, true, 16), '2 % would take 30 samples');
  assert.equal(forecastText(forecast, false, 256), '0.5 % would take 4\u202f800 samples');
  assert.equal(forecastText(forecast, false, 65536), '');
});

test('forecastText: nothing where nothing is known, and a plateau is said so', () => {
  assert.equal(forecastText(told(undefined), true, 64), '');
  assert.equal(forecastText(told(null), true, 64), '');
  const waiting = told({ plateau: false, steps: [{ error: 0.01, samples: 20, seconds: null }] });
  assert.equal(forecastText(waiting, true, 64), '');
  const plateau = told({ plateau: true, steps: [] });
  assert.equal(forecastText(plateau, true, 64), 'more samples have not helped lately');
  assert.equal(forecastText(plateau, false, 64), '');
});

test('refinedText: which part of the picture is still refined', () => {
  assert.equal(refinedText(false, 0.344), ' · refining 34 % of it');
  assert.equal(refinedText(false, 0.0001), ' · refining 1 % of it');
  for (const [final, refined] of [[true, 0.3], [false, 1], [false, 0]] as const) assert.equal(refinedText(final, refined), '');
});
