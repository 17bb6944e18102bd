// `window.heliograph`: what the page knows, to be read by tests and in the browser's console (docs/reference/page.md). Read-
// only.

import type { Viewer } from '../viewer.js';
import type { Pace } from '../wire/protocol.js';

export interface Diagnostics {
  readonly connected: boolean;
  readonly connection: string;
  readonly server: string | null; // its version
  readonly scene: { readonly name: string; readonly state: string } | null;
  readonly lastFrame: {
    readonly frameId: number;
    readonly inputId: number;
    readonly samples: number;
    readonly width: number;
    readonly height: number;
    readonly final: boolean;
    readonly exact: boolean;
    readonly denoised: boolean;
    readonly codec: string;
    readonly devices: readonly string[]; // that took part
  } | null;
  readonly partition: { readonly frameId: number; readonly devices: readonly string[] } | null; // on the picture
  readonly lastInputId: number;
  readonly framesPresented: number;
  readonly framesDropped: number;
  readonly motionToPhotonMs: { readonly median: number | null; readonly p95: number | null; readonly last: number | null };
  readonly pace: Pace | null; // what limits, as the server last said
  readonly settings: Readonly<Record<string, unknown>>; // as the server last said
  readonly camera: unknown;
  readonly pathPlaying: boolean;
  readonly view: string | null; // the id of the view that is looked at
  readonly watching: boolean; // another viewer drives what is seen
}

declare global {
  interface Window {
    readonly heliograph: { readonly state: Diagnostics };
  }
}

export function exposeDiagnostics(viewer: Viewer): void {
  const read = (): Diagnostics => {
    const { state, settings, controller } = viewer;
    const { motionToPhoton } = viewer.stream;
    const frame = state.lastFrame;
    const { shown } = viewer.partition;
    return Object.freeze({
      connected: state.connection.name === 'open' && state.hello !== null,
      connection: state.connection.name,
      server: state.hello?.server ?? null,
      scene: state.scene === null ? null : { name: state.scene.name, state: state.scene.state },
      lastFrame:
        frame === null
          ? null
          : {
              frameId: frame.frameId,
              inputId: frame.inputId,
              samples: frame.samples,
              width: frame.width,
              height: frame.height,
              final: frame.final,
              exact: frame.exact,
              denoised: frame.denoised,
              codec: frame.codec,
              devices: [...frame.devices],
            },
      partition: shown === null ? null : { frameId: shown.map.frameId, devices: [...shown.map.devices] },
      lastInputId: state.lastInputId,
      framesPresented: state.framesPresented,
      framesDropped: state.framesDropped,
      motionToPhotonMs: {
        median: motionToPhoton.window.quantile(0.5),
        p95: motionToPhoton.window.quantile(0.95),
        last: motionToPhoton.window.values.at(-1) ?? null,
      },
      pace: state.stats?.pace ?? null,
      settings: Object.fromEntries(settings.rows.map((row) => [row.name, settings.confirmed(row.name)])),
      camera: structuredClone(controller.camera),
      pathPlaying: state.pathPlaying,
      view: viewer.watching.looked,
      watching: viewer.watching.active,
    });
  };
  const diagnostics = Object.freeze(Object.defineProperty({}, 'state', { get: read, enumerable: true }));
  Object.defineProperty(window, 'heliograph', { value: diagnostics, writable: false });
}
