// A picture for the fake server: three balls on a chequered floor under a sky, traced here, so that a camera, a setting
// and a scene visibly change it. Not the kernel's picture and not meant to be.

import { deflateSync } from 'node:zlib';

const subtract = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const madd = (a, b, t) => [a[0] + b[0] * t, a[1] + b[1] * t, a[2] + b[2] * t];
const unit = (a) => madd([0, 0, 0], a, 1 / Math.hypot(...a));
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const SUN = unit([0.5, 0.8, 0.4]);

function balls(scene) {
  return scene === 'cornell'
    ? [
        { center: [-1.3, 1, 0], radius: 1, color: [0.8, 0.25, 0.18], mirror: 0.2 },
        { center: [1.2, 0.7, 0.9], radius: 0.7, color: [0.2, 0.45, 0.8], mirror: 0.3 },
        { center: [0.9, 1.3, -1.8], radius: 1.3, color: [0.75, 0.75, 0.75], mirror: 0.7 },
      ]
    : [{ center: [0, 1.4, 0], radius: 1.4, color: [0.95, 0.7, 0.3], mirror: 0.5 }];
}

function hit(list, origin, direction) {
  let best = null;
  for (const ball of list) {
    const to = subtract(origin, ball.center);
    const half = dot(to, direction);
    const root = half * half - dot(to, to) + ball.radius * ball.radius;
    const t = -half - Math.sqrt(Math.max(root, 0));
    if (root > 0 && t > 1e-3 && (best === null || t < best.t)) best = { t, ball };
  }
  const floor = -origin[1] / direction[1];
  if (floor > 1e-3 && (best === null || floor < best.t)) best = { t: floor, ball: null };
  return best;
}

function radiance(list, origin, direction, depth) {
  const found = hit(list, origin, direction);
  if (found === null) {
    const up = Math.max(0, direction[1]);
    return [0.75 - 0.5 * up, 0.82 - 0.4 * up, 0.92 - 0.2 * up];
  }
  const point = madd(origin, direction, found.t);
  const normal = found.ball === null ? [0, 1, 0] : unit(subtract(point, found.ball.center));
  const odd = (Math.floor(point[0]) + Math.floor(point[2])) & 1;
  const color = found.ball?.color ?? (odd ? [0.62, 0.6, 0.56] : [0.3, 0.31, 0.33]);
  const lit = hit(list, madd(point, normal, 2e-3), SUN) === null ? Math.max(0, dot(normal, SUN)) : 0;
  const mirror = depth > 0 ? (found.ball?.mirror ?? 0.08) : 0;
  const reflected =
    mirror > 0
      ? radiance(list, madd(point, normal, 2e-3), madd(direction, normal, -2 * dot(direction, normal)), depth - 1)
      : [0, 0, 0];
  return color.map((c, i) => c * (0.28 + 0.85 * lit) * (1 - mirror) + reflected[i] * mirror);
}

function chunk(type, data) {
  const body = Buffer.concat([Buffer.from(type, 'latin1'), data]);
  const out = Buffer.alloc(body.length + 8);
  out.writeUInt32BE(data.length, 0);
  body.copy(out, 4);
  out.writeUInt32BE(crc32(body), body.length + 4);
  return out;
}

const CRC_TABLE = Uint32Array.from({ length: 256 }, (_, n) => {
  let c = n;
  for (let k = 0; k < 8; k += 1) c = c & 1 ? 0xedb88320 ^ (c >>> 1) : c >>> 1;
  return c >>> 0;
});

function crc32(bytes) {
  let c = 0xffffffff;
  for (const byte of bytes) c = CRC_TABLE[(c ^ byte) & 255] ^ (c >>> 8);
  return (c ^ 0xffffffff) >>> 0;
}

/** RGB rows as a PNG file. */
function png(width, height, pixels) {
  const header = Buffer.alloc(13);
  header.writeUInt32BE(width, 0);
  header.writeUInt32BE(height, 4);
  header.set([8, 2, 0, 0, 0], 8);
  const rows = Buffer.alloc(height * (width * 3 + 1));
  for (let y = 0; y < height; y += 1) {
    pixels.copy(rows, y * (width * 3 + 1) + 1, y * width * 3, (y + 1) * width * 3);
  }
  const signature = Buffer.from([0x89, 0x50, 0x4e, 0x47, 0x0d, 0x0a, 0x1a, 0x0a]);
  return Buffer.concat([
    signature,
    chunk('IHDR', header),
    chunk('IDAT', deflateSync(rows, { level: 1 })),
    chunk('IEND', Buffer.alloc(0)),
  ]);
}

/** PNG of `scene` seen by `camera`, brighter by `exposure` stops. */
export function paint(scene, camera, width, height, exposure) {
  const list = balls(scene);
  const right = unit(cross(camera.forward, camera.up));
  const slope = Math.tan((camera.fieldOfView * Math.PI) / 360);
  const gain = 2 ** exposure;
  const pixels = Buffer.alloc(width * height * 3);
  for (let y = 0; y < height; y += 1) {
    for (let x = 0; x < width; x += 1) {
      const across = ((2 * (x + 0.5)) / width - 1) * slope * (width / height);
      const down = (1 - (2 * (y + 0.5)) / height) * slope;
      const direction = unit(madd(madd(camera.forward, right, across), camera.up, down));
      const color = radiance(list, camera.position, direction, 2);
      for (let i = 0; i < 3; i += 1)
        pixels[(y * width + x) * 3 + i] = Math.min(255, 255 * (gain * color[i]) ** (1 / 2.2));
    }
  }
  return png(width, height, pixels);
}
