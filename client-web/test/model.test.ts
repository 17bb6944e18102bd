import assert from 'node:assert/strict';
import { test } from 'node:test';
import { chartTop } from '../src/panels/statistics/chart.js';
import { bytes, count, percent, settingNumber, whole } from '../src/page/format.js';
import { MotionToPhoton, RateMeter, Window } from '../src/picture/latency.js';
import type { SettingRow } from '../src/wire/protocol.js';
import { pictureSize } from '../src/picture/resolution.js';
import { fileName } from '../src/page/scene_name.js';
import { SettingsModel } from '../src/panels/settings/settings_model.js';
import { fromSlider, SLIDER_STEPS, stepped, toSlider } from '../src/panels/settings/slider_scale.js';
import { backoffDelay, socketUrl } from '../src/wire/socket.js';
import { tokenOf, withoutToken } from '../src/wire/token.js';

function row(name: string, type: SettingRow['type'], preset: SettingRow['default'], low = 0, high = 0): SettingRow {
  return {
    name,
    type,
    default: preset,
    low,
    high,
    unit: '',
    label: name,
    effect: '',
    price: '',
    group: 'picture',
    acts: name === 'fieldOfView' ? 'command' : 'film',
    help: '',
    choices: [],
  };
}

const ROWS = [
  row('samples', 'int', 64, 1, 65536),
  row('exposure', 'float', 0, -10, 10),
  row('shadows', 'bool', true),
  row('fieldOfView', 'float', 60, 1, 179),
];

function model(): SettingsModel {
  const settings = new SettingsModel();
  settings.setSchema(ROWS);
  return settings;
}

test('SettingsModel: a change shows at once and the echo confirms it', () => {
  const settings = model();
  settings.change({ samples: 8 }, 5);
  assert.equal(settings.value('samples'), 8);
  assert.equal(settings.confirmed('samples'), 64);
  settings.echo({ samples: 8, exposure: 0, shadows: true }, 5);
  assert.equal(settings.confirmed('samples'), 8);
  assert.deepEqual(settings.restorable(), { samples: 8 });
});

test('SettingsModel: an echo of an older message leaves the newer change on show', () => {
  const settings = model();
  settings.change({ samples: 8 }, 5);
  settings.change({ samples: 9 }, 6);
  settings.echo({ samples: 8 }, 5);
  assert.equal(settings.value('samples'), 9);
  settings.echo({ samples: 8 }, null);
  assert.equal(settings.value('samples'), 9);
});

test('SettingsModel: a refused value falls back, the message stands by its field until it is changed', () => {
  const settings = model();
  settings.echo({ samples: 16 }, null);
  settings.change({ samples: 0 }, 7);
  assert.deepEqual(settings.refused('samples: 0, allowed: 1 to 65536', 7), ['samples']);
  assert.equal(settings.value('samples'), 16);
  assert.equal(settings.error('samples'), 'samples: 0, allowed: 1 to 65536');
  settings.change({ samples: 2 }, 8);
  assert.equal(settings.error('samples'), null);
});

test('SettingsModel: a refusal without an id finds its field by name', () => {
  const settings = model();
  settings.change({ exposure: 3 }, 1);
  settings.change({ samples: 0 }, 2);
  assert.deepEqual(settings.refused('samples: 0, allowed: 1 to 65536', null), ['samples']);
  assert.equal(settings.value('exposure'), 3);
  assert.equal(settings.error('exposure'), null);
});

test('SettingsModel: of a message with several values all fall back, only the named one bears the error', () => {
  const settings = model();
  settings.change({ exposure: 99, samples: 4 }, 3);
  assert.deepEqual(settings.refused('exposure: 99, allowed: -10 to 10', 3), ['exposure', 'samples']);
  assert.equal(settings.value('samples'), 64);
  assert.equal(settings.error('samples'), null);
  assert.ok(settings.error('exposure') !== null);
  assert.deepEqual(settings.restorable(), {});
});

test('SettingsModel: a reconnect forgets what was pending and keeps what to restore', () => {
  const settings = model();
  settings.change({ exposure: 1.1 }, 1);
  settings.setSchema(ROWS);
  assert.equal(settings.value('exposure'), 0);
  assert.deepEqual(settings.restorable(), { exposure: 1.1 });
});

test('SettingsModel: 32-bit floats of the server equal what was set, and session settings are no rows', () => {
  const settings = model();
  settings.change({ exposure: 0.1 }, 1);
  settings.echo({ exposure: Math.fround(0.1) }, null);
  settings.echo({ exposure: 0 }, null);
  assert.equal(settings.value('exposure'), 0);
  assert.ok(!settings.rows.some((entry) => entry.name === 'fieldOfView'));
});

test('slider: ends are exact, the default is reachable, positions and values agree', () => {
  for (const entry of [...ROWS.filter((candidate) => candidate.type !== 'bool'), row('radius', 'float', 1, 0, 1000)]) {
    assert.equal(fromSlider(entry, 0), entry.low);
    assert.equal(fromSlider(entry, SLIDER_STEPS), entry.high);
    assert.equal(fromSlider(entry, toSlider(entry, Number(entry.default))), entry.default, entry.name);
    let last = -Infinity;
    for (let position = 0; position <= SLIDER_STEPS; position += 10) {
      const value = fromSlider(entry, position);
      assert.ok(value >= last, `${entry.name} falls at ${position}`);
      last = value;
    }
  }
});

test('slider: an arrow key always changes a whole number by one and never leaves the range', () => {
  const samples = ROWS[0]!;
  assert.equal(stepped(samples, 64, 1, false), 65);
  assert.equal(stepped(samples, 1, -1, false), 1);
  assert.ok(stepped(samples, 64, 1, true) >= 74);
  assert.equal(stepped(ROWS[1]!, 10, 1, true), 10);
});

test('pictureSize: follows the window, caps pixels at 1080p and keeps the shape', () => {
  assert.deepEqual(pictureSize(1440, 900, 1, 'capped'), { width: 1440, height: 900 });
  const capped = pictureSize(2560, 1440, 2, 'capped');
  assert.deepEqual(capped, { width: 1920, height: 1080 });
  const phone = pictureSize(390, 844, 3, 'capped');
  assert.ok(phone.width * phone.height <= 1920 * 1080 && Math.abs(phone.width / phone.height - 390 / 844) < 0.002);
  assert.deepEqual(pictureSize(390, 844, 3, 'full'), { width: 1170, height: 2532 });
  assert.deepEqual(pictureSize(1440, 900, 2, 'half'), { width: 720, height: 450 });
  assert.deepEqual(pictureSize(0, 0, 1, 'full'), { width: 16, height: 16 });
  const huge = pictureSize(20000, 10000, 2, 'full');
  assert.ok(huge.width <= 8192 && huge.width * huge.height <= 33_177_600);
});

test('MotionToPhoton: counts the first picture of an input, once', () => {
  const meter = new MotionToPhoton(10);
  meter.sent(1, 100);
  meter.sent(3, 120);
  assert.equal(meter.presented(2, 130), null);
  assert.equal(meter.presented(3, 150), 30);
  assert.equal(meter.presented(3, 170), null);
  assert.deepEqual(meter.window.values, [30]);
});

test('Window: nearest-rank quantiles of the newest values', () => {
  const window = new Window(4);
  assert.equal(window.quantile(0.5), null);
  for (const value of [9, 4, 1, 3, 2]) window.push(value);
  assert.deepEqual([window.quantile(0), window.quantile(0.5), window.quantile(0.95)], [1, 2, 4]);
});

test('RateMeter: forgets what is older than its span', () => {
  const meter = new RateMeter(2000);
  meter.push(0, 100);
  meter.push(1500, 300);
  assert.equal(meter.events(1900), 1);
  assert.equal(meter.amount(2100), 150);
});

test('backoffDelay: doubles from 0.25 s to 5 s, spread by 20 %', () => {
  assert.equal(backoffDelay(0, 0.5), 250);
  assert.equal(backoffDelay(2, 0.5), 1000);
  assert.equal(backoffDelay(1000, 0.5), 5000);
  assert.ok(backoffDelay(9, 0) >= 4500 && backoffDelay(9, 0.999) <= 5500);
});

test('socketUrl and tokenOf: beside the page, the token only from the fragment', () => {
  assert.equal(socketUrl('http://localhost:8080/#token=abc'), 'ws://localhost:8080/ws');
  assert.equal(socketUrl('https://example.org/view/?x=1'), 'wss://example.org/view/ws');
  assert.equal(tokenOf('http://localhost/#token=a%2Bb'), 'a+b');
  assert.equal(tokenOf('http://localhost/?token=abc'), null);
  assert.equal(withoutToken('http://localhost/?view=1#token=abc'), 'http://localhost/?view=1');
  assert.equal(withoutToken('http://localhost/#scene=a&token=abc&fov=50'), 'http://localhost/#scene=a&fov=50');
});

test('format: figures as people read them', () => {
  assert.deepEqual([count(64), count(999.6), count(1_296_000), count(402_100)], ['64', '1.00 k', '1.30 M', '402 k']);
  assert.deepEqual([whole(66454), percent(0.0123), bytes(312e6)], ['66\u202f454', '1.2 %', '312 MB']);
  assert.equal(settingNumber(Math.fround(0.004)), '0.004');
  assert.equal(fileName('../up/My Scene.glb', 10, 20, 3, 'png'), 'heliograph-my-scene-10x20-3spp.png');
  assert.equal(chartTop([]), 40);
  assert.equal(chartTop([80, 90, 85]), 100);
});
