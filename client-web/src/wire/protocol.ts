// The server's control messages of docs/reference/protocol.md. What comes from the server is checked here (and in frame.ts), so the rest
// of the page deals with typed values only.

import type { Bounds, Camera } from '../camera/camera.js';
import { fieldsOf, isObject, listOf, numberOf, numbersOf, settingValuesOf, textOf, type Fields, type Numbers } from './fields.js';
import { ProtocolError } from './frame.js';
import { accuracyOf, type AccuracyMessage } from './accuracy_message.js';
import { cameraOf, vectorOf } from './camera_fields.js';
import { effectCostsOf, type EffectCostsMessage } from './effect_costs_message.js';
import { errorMapOf, type ErrorMap } from './errors_message.js';
import { partitionOf, type Partition } from './partition_message.js';
import { poolOf, type PoolStats } from './pool_stats.js';
import { pickedOf, type PickedMessage } from './picked_message.js';
import { watchingOf, type WatchingMessage } from './watching_message.js';

export const PROTOCOL = 'heliograph.v1';
export type SettingValue = boolean | number | string;
export type SettingValues = Readonly<Record<string, SettingValue>>;

export interface SettingRow {
  readonly name: string;
  readonly group: string; // picture, effects, renderer or hybrid
  readonly acts: string; // film, display, loop or command: a viewer does not send the last ones
  readonly type: 'bool' | 'int' | 'float' | 'choice';
  readonly default: SettingValue;
  readonly low: number;
  readonly high: number;
  readonly unit: string;
  readonly label: string;
  readonly effect: string;
  readonly price: string; // up, down, on, off or empty: which direction is exact and dearer
  readonly help: string;
  readonly choices: readonly string[];
}

export interface SceneEntry {
  readonly name: string;
  readonly description: string;
}

export interface NamedCamera extends Camera {
  readonly name: string;
}

export interface EffectReason {
  readonly name: string;
  readonly calledFor: boolean; // by the scene
  readonly choice: boolean; // the viewer's alone, and there is something to see
  readonly because: string;
  readonly setting: string | null; // that switches it
  readonly help: string;
  readonly simulated: boolean; // false: the server knows of it, and no device can
}

export interface SceneReady {
  readonly camera: Camera;
  readonly cameras: readonly NamedCamera[];
  readonly paths: readonly string[];
  readonly variants: readonly string[]; // looks that the file offers
  readonly variant: number | null; // the one that is shown; null: the file's own
  readonly bounds: Bounds;
  readonly radius: number;
  readonly triangles: number;
  readonly instances: number;
  readonly lights: number;
  readonly warnings: readonly string[];
  readonly effects: readonly EffectReason[];
}

/** A kind of device that the server can have, a row of its table. */
export interface DeviceKind {
  readonly name: string; // of its devices, "vulkan" of "vulkan:0"
  readonly words: readonly string[]; // of the setting `device` that this server offers for it
  readonly kind: string; // processor, gpu, preview or node
  readonly side: string; // of a manual balance: cpu or gpu
  readonly bit: number; // in a frame's header
}

export interface Hello {
  readonly type: 'hello';
  readonly protocol: string;
  readonly server: string;
  readonly viewer: number;
  readonly view: string; // the id of its own view
  readonly key: string; // to its seats, for when it comes back on another connection
  readonly schema: readonly SettingRow[];
  readonly devices: readonly DeviceKind[];
  readonly scenes: readonly SceneEntry[];
  readonly videos: readonly string[]; // that it can make
  readonly maxUnacked: number;
}

export interface SceneMessage {
  readonly type: 'scene';
  readonly name: string;
  readonly state: 'loading' | 'ready' | 'failed';
  readonly what: string; // stage while loading, reason when failed
  readonly share: number; // 0..1 while loading
  readonly ready: SceneReady | null;
}

/** What a device does for the picture. */
export interface DevicePart {
  readonly device: string;
  readonly part: string; // works, probes, parked or lost
  readonly reason: string;
  readonly mraysPerSecond: number;
  readonly share: number; // 0..1 of the last frame's cost
  readonly idleShare: number; // 0..1 of the last frame's time
}

/** What pictures are made smaller or worse for while the view moves, and by how much. */
export interface Pace {
  readonly limit: 'none' | 'server' | 'line' | 'viewer';
  readonly scale: number; // width of a picture over that of a full one
  readonly quality: number; // JPEG
  readonly codec: string; // of the last picture
  readonly fullMs: number; // a pass in full size
  readonly roundTripMs: number; // the least
  readonly lineMs: number; // that pictures queue on the line
  readonly viewerMs: number; // that they take longer here than they must
  readonly bytesPerSecond: number; // the most that was delivered
}

export interface SchedulerStats {
  readonly endLossMs: number; // last finish minus mean finish
  readonly decisionMs: number;
  readonly batches: number;
  readonly reissued: number;
}

/** An error that the picture comes down to, and when. */
export interface ForecastStep {
  readonly error: number; // relative
  readonly samples: number;
  readonly seconds: number | null; // from the newest frame of the statistics; null: not known
}

/** How the picture's error goes on falling. */
export interface Forecast {
  readonly plateau: boolean; // more samples have not helped lately
  readonly steps: readonly ForecastStep[]; // the largest error first
}

/** What pictures of a moving view do without for the time budget. */
export interface Autopilot {
  readonly budgetMs: number;
  readonly ms: number; // of a picture as it is, predicted; 0: not known
  readonly scale: number; // width of a picture over that of a full one
  readonly steps: readonly { setting: string; before: string; after: string; msWithout: number }[];
}

export interface Stats {
  readonly type: 'stats';
  readonly device: string;
  readonly framesPerSecond: number;
  readonly samples: number;
  readonly targetSamples: number;
  readonly relativeError: number;
  readonly forecast: Forecast | null; // not known
  readonly autopilot: Autopilot | null; // no budget
  readonly refined: number; // 0..1: part of the picture that still gets samples
  readonly autoExposure: number | null; // EV that the picture chose itself; null: it does not
  readonly rays: Numbers;
  readonly mraysPerSecond: number;
  readonly ms: Numbers;
  readonly overheadShare: number;
  readonly tiles: Numbers;
  readonly parts: readonly DevicePart[];
  readonly scheduler: SchedulerStats | null;
  readonly pool: PoolStats | null; // there is none
  readonly pace: Pace | null; // a server that does not say: null
  readonly viewers: number;
  readonly watchers: number; // of the view, beside who drives it
  readonly residentBytes: number;
  readonly nonfiniteSamples: number;
}

export interface PathResult {
  readonly frames: number;
  readonly msMean: number;
  readonly msMedian: number;
  readonly msP95: number;
  readonly fpsMean: number;
  readonly fpsMin: number;
}

/** The picture is smaller than the page asked for. */
export interface ResolutionMessage {
  readonly type: 'resolution';
  readonly wanted: readonly [number, number]; // pixels
  readonly given: readonly [number, number];
}

export type ServerMessage =
  | Hello
  | SceneMessage
  | Stats
  | Partition
  | ErrorMap
  | AccuracyMessage
  | EffectCostsMessage
  | PickedMessage
  | WatchingMessage
  | ResolutionMessage
  | { readonly type: 'settings'; readonly values: SettingValues; readonly inputId: number | null }
  | { readonly type: 'path'; readonly playing: boolean; readonly result: PathResult | null }
  | { readonly type: 'driveAsked'; readonly viewer: number } // wants to drive what this page drives
  | { readonly type: 'notice'; readonly text: string }
  | { readonly type: 'error'; readonly message: string; readonly about: string; readonly inputId: number | null }
  | { readonly type: 'pong'; readonly time: number };

const inputIdOf = (value: unknown): number | null => (typeof value === 'number' ? value : null);

function sizeOf(value: unknown, where: string): readonly [number, number] {
  const [width, height] = listOf(value);
  if (typeof width !== 'number' || typeof height !== 'number') {
    throw new ProtocolError(`${where}: ${JSON.stringify(value)}, allowed: two numbers`);
  }
  return [width, height];
}

function settingRowOf(value: unknown): SettingRow {
  const fields = fieldsOf(value);
  const type = fields['type'];
  const preset = fields['default'];
  if (type !== 'bool' && type !== 'int' && type !== 'float' && type !== 'choice') {
    throw new ProtocolError(
      `hello.schema ${textOf(fields['name'])}: type ${String(type)}, allowed: bool, int, float, choice`,
    );
  }
  const choices = listOf(fields['choices']).map(textOf);
  // A choice's default may come as the word or as its index.
  const word = type === 'choice' && typeof preset === 'number' ? choices[preset] : preset;
  return {
    name: textOf(fields['name']),
    group: textOf(fields['group']),
    acts: textOf(fields['acts']),
    type,
    default: typeof word === 'boolean' || typeof word === 'number' || typeof word === 'string' ? word : 0,
    low: numberOf(fields['low']),
    high: numberOf(fields['high']),
    unit: textOf(fields['unit']),
    label: textOf(fields['label']) || textOf(fields['name']),
    effect: textOf(fields['effect']),
    price: textOf(fields['price']),
    help: textOf(fields['help']),
    choices,
  };
}

function deviceKindOf(entry: unknown): DeviceKind {
  const row = fieldsOf(entry);
  return {
    name: textOf(row['name']),
    words: listOf(row['words']).map((word) => textOf(word)),
    kind: textOf(row['kind']),
    side: textOf(row['side']),
    bit: numberOf(row['bit']),
  };
}

function helloOf(fields: Fields): Hello {
  return {
    type: 'hello',
    protocol: textOf(fields['protocol']),
    server: textOf(fields['server']),
    viewer: numberOf(fields['viewer']),
    view: textOf(fields['view']),
    key: textOf(fields['key']),
    schema: listOf(fields['schema']).map(settingRowOf),
    devices: listOf(fields['devices']).map(deviceKindOf),
    scenes: listOf(fields['scenes']).map((entry) => {
      const scene = fieldsOf(entry);
      return { name: textOf(scene['name']), description: textOf(scene['description']) };
    }),
    videos: listOf(fields['videos']).map(textOf),
    maxUnacked: numberOf(fields['maxUnacked'], 2),
  };
}

function sceneReadyOf(fields: Fields): SceneReady {
  const bounds = fieldsOf(fields['bounds']);
  return {
    camera: cameraOf(fields['camera'], 'scene.camera'),
    cameras: listOf(fields['cameras']).map((entry) => ({
      name: textOf(fieldsOf(entry)['name']),
      ...cameraOf(entry, 'scene.cameras'),
    })),
    paths: listOf(fields['paths']).map(textOf),
    variants: listOf(fields['variants']).map(textOf),
    variant: typeof fields['variant'] === 'number' ? fields['variant'] : null,
    bounds: { low: vectorOf(bounds['low'], 'scene.bounds.low'), high: vectorOf(bounds['high'], 'scene.bounds.high') },
    radius: Math.max(numberOf(fields['radius'], 1), 1e-6),
    triangles: numberOf(fields['triangles']),
    instances: numberOf(fields['instances']),
    lights: numberOf(fields['lights']),
    warnings: listOf(fields['warnings']).map(textOf),
    effects: listOf(fields['effects']).map((entry) => {
      const effect = fieldsOf(entry);
      return {
        name: textOf(effect['name']),
        calledFor: effect['calledFor'] === true,
        choice: effect['choice'] === true,
        because: textOf(effect['because']),
        setting: textOf(effect['setting']) || null,
        help: textOf(effect['help']),
        simulated: effect['simulated'] === true,
      };
    }),
  };
}

function sceneOf(fields: Fields): SceneMessage {
  const state = fields['state'];
  if (state !== 'loading' && state !== 'ready' && state !== 'failed') {
    throw new ProtocolError(`scene.state: ${String(state)}, allowed: loading, ready, failed`);
  }
  return {
    type: 'scene',
    name: textOf(fields['name']),
    state,
    what: textOf(fields['what']),
    share: numberOf(fields['share']),
    ready: state === 'ready' ? sceneReadyOf(fields) : null,
  };
}

function devicePartOf(value: unknown): DevicePart {
  const fields = fieldsOf(value);
  return {
    device: textOf(fields['device']),
    part: textOf(fields['part']),
    reason: textOf(fields['reason']),
    mraysPerSecond: numberOf(fields['mraysPerSecond']),
    share: numberOf(fields['share']),
    idleShare: numberOf(fields['idleShare']),
  };
}

function schedulerOf(value: unknown): SchedulerStats | null {
  if (!isObject(value)) return null;
  return {
    endLossMs: numberOf(value['endLossMs']),
    decisionMs: numberOf(value['decisionMs']),
    batches: numberOf(value['batches']),
    reissued: numberOf(value['reissued']),
  };
}

function paceOf(value: unknown): Pace | null {
  if (!isObject(value)) return null;
  const limit = textOf(value['limit']);
  return {
    limit: limit === 'server' || limit === 'line' || limit === 'viewer' ? limit : 'none',
    scale: numberOf(value['scale'], 1),
    quality: numberOf(value['quality']),
    codec: textOf(value['codec']),
    fullMs: numberOf(value['fullMs']),
    roundTripMs: numberOf(value['roundTripMs']),
    lineMs: numberOf(value['lineMs']),
    viewerMs: numberOf(value['viewerMs']),
    bytesPerSecond: numberOf(value['bytesPerSecond']),
  };
}

function autopilotOf(value: unknown): Autopilot | null {
  if (!isObject(value)) return null;
  const steps = listOf(value['steps']).map((entry) => {
    const { setting, before, after, msWithout } = fieldsOf(entry);
    return { setting: textOf(setting), before: textOf(before), after: textOf(after), msWithout: numberOf(msWithout) };
  });
  return { budgetMs: numberOf(value['budgetMs']), ms: numberOf(value['ms']), scale: numberOf(value['scale'], 1), steps };
}

function forecastOf(value: unknown): Forecast | null {
  if (!isObject(value)) return null;
  const steps = listOf(value['steps']).map((entry) => {
    const fields = fieldsOf(entry);
    const seconds = fields['seconds'];
    return {
      error: numberOf(fields['error']),
      samples: numberOf(fields['samples']),
      seconds: typeof seconds === 'number' ? seconds : null,
    };
  });
  return { plateau: value['plateau'] === true, steps };
}

function statsOf(fields: Fields): Stats {
  return {
    type: 'stats',
    device: textOf(fields['device']),
    framesPerSecond: numberOf(fields['framesPerSecond']),
    samples: numberOf(fields['samples']),
    targetSamples: numberOf(fields['targetSamples']),
    relativeError: numberOf(fields['relativeError'], 1),
    forecast: forecastOf(fields['forecast']),
    autopilot: autopilotOf(fields['autopilot']),
    refined: numberOf(fields['refined'], 1),
    autoExposure: typeof fields['autoExposure'] === 'number' ? fields['autoExposure'] : null,
    rays: numbersOf(fields['rays']),
    mraysPerSecond: numberOf(fields['mraysPerSecond']),
    ms: numbersOf(fields['ms']),
    overheadShare: numberOf(fields['overheadShare']),
    tiles: numbersOf(fields['tiles']),
    parts: listOf(fields['parts']).map(devicePartOf),
    scheduler: schedulerOf(fields['scheduler']),
    pool: poolOf(fields['pool']),
    pace: paceOf(fields['pace']),
    viewers: numberOf(fields['viewers']),
    watchers: numberOf(fields['watchers']),
    residentBytes: numberOf(fields['residentBytes']),
    nonfiniteSamples: numberOf(fields['nonfiniteSamples']),
  };
}

function pathResultOf(value: unknown): PathResult | null {
  if (!isObject(value)) return null;
  return {
    frames: numberOf(value['frames']),
    msMean: numberOf(value['msMean']),
    msMedian: numberOf(value['msMedian']),
    msP95: numberOf(value['msP95']),
    fpsMean: numberOf(value['fpsMean']),
    fpsMin: numberOf(value['fpsMin']),
  };
}

/** Reads a text message; null for a type this page does not know (a newer server). Throws ProtocolError. */
export function parseMessage(text: string): ServerMessage | null {
  let fields: unknown;
  try {
    fields = JSON.parse(text);
  } catch {
    throw new ProtocolError('message: not JSON');
  }
  if (!isObject(fields)) throw new ProtocolError('message: not a JSON object');
  switch (fields['type']) {
    case 'hello':
      return helloOf(fields);
    case 'scene':
      return sceneOf(fields);
    case 'stats':
      return statsOf(fields);
    case 'accuracy':
      return accuracyOf(fields);
    case 'effectCosts':
      return effectCostsOf(fields);
    case 'picked':
      return pickedOf(fields);
    case 'errors':
      return errorMapOf(fields);
    case 'partition':
      return partitionOf(fields);
    case 'settings':
      return { type: 'settings', values: settingValuesOf(fields['values']), inputId: inputIdOf(fields['inputId']) };
    case 'path':
      return { type: 'path', playing: fields['playing'] === true, result: pathResultOf(fields['result']) };
    case 'watching':
      return watchingOf(fields);
    case 'resolution':
      return {
        type: 'resolution',
        wanted: sizeOf(fields['wanted'], 'resolution.wanted'),
        given: sizeOf(fields['given'], 'resolution.given'),
      };
    case 'driveAsked':
      return { type: 'driveAsked', viewer: numberOf(fields['viewer']) };
    case 'notice':
      return { type: 'notice', text: textOf(fields['text']) };
    case 'error':
      return {
        type: 'error',
        message: textOf(fields['message']),
        about: textOf(fields['about']),
        inputId: inputIdOf(fields['inputId']),
      };
    case 'pong':
      return { type: 'pong', time: numberOf(fields['time']) };
    default:
      return null;
  }
}
