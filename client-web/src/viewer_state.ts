// What the panels read of a viewer's session, and by which names they hear of changes.

import type { Frame } from './wire/frame.js';
import type { Hello, PathResult, SceneMessage, SceneReady, Stats } from './wire/protocol.js';
import type { PictureSize, ResolutionMode } from './picture/resolution.js';
import type { ConnectionState } from './wire/socket.js';

export type Topic =
  | 'connection'
  | 'hello'
  | 'scene'
  | 'settings'
  | 'stats'
  | 'path'
  | 'frame'
  | 'partition'
  | 'errors'
  | 'effectCosts'
  | 'accuracy'
  | 'camera'
  | 'pick'
  | 'jump' // the viewer is about to leave for another viewpoint or scene
  | 'resolution'
  | 'watching';

export type Message = { readonly kind: 'notice' | 'error'; readonly text: string };

export interface ViewerState {
  connection: ConnectionState;
  hello: Hello | null;
  scene: SceneMessage | null; // the newest word on it
  ready: SceneReady | null; // of the scene that is shown
  readyName: string;
  ownScene: string; // that the server opened by itself
  stats: Stats | null;
  pathPlaying: boolean;
  pathResult: PathResult | null;
  lastFrame: Frame | null; // the newest that was presented
  framesPresented: number;
  framesDropped: number;
  lastInputId: number;
  picturesAwaited: number;
  resolution: PictureSize; // asked for
  given: PictureSize | null; // what the server has memory for, where that is less
  resolutionMode: ResolutionMode;
}

export function initialState(resolutionMode: ResolutionMode): ViewerState {
  return {
    connection: { name: 'connecting', refusal: null },
    hello: null,
    scene: null,
    ready: null,
    readyName: '',
    ownScene: '',
    stats: null,
    pathPlaying: false,
    pathResult: null,
    lastFrame: null,
    framesPresented: 0,
    framesDropped: 0,
    lastInputId: 0,
    picturesAwaited: 0,
    resolution: { width: 0, height: 0 },
    given: null,
    resolutionMode,
  };
}
