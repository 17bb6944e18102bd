import assert from 'node:assert/strict';
import { test } from 'node:test';
import { chooseUpload, isUploaded, sceneToOpen, uploadHead, type UploadLimits } from '../src/upload/upload_files.js';
import { displayName } from '../src/page/scene_name.js';

const LIMITS: UploadLimits = { bytes: 2 ** 20, files: 3, free: 2 ** 30 };
const ID = '0123456789abcdef0123456789abcdef';
const files = (...paths: string[]): { path: string; bytes: number }[] => paths.map((path) => ({ path, bytes: 10 }));

function chosen(...paths: string[]): { scene: string; files: string[]; leftOut: number } {
  const choice = chooseUpload(files(...paths), LIMITS);
  assert.ok(choice.name === 'chosen', JSON.stringify(choice));
  return { scene: choice.scene.path, files: choice.files.map(({ path }) => path), leftOut: choice.leftOut };
}

function refused(list: readonly { path: string; bytes: number }[], limits: UploadLimits | null = LIMITS): string {
  const choice = chooseUpload(list, limits);
  assert.ok(choice.name === 'refused', JSON.stringify(choice));
  return choice.why;
}

test('the scene nearest to the top is opened, with what may belong to it', () => {
  assert.deepEqual(chosen('car/old/car.glb', 'car/car.OBJ', 'car/car.mtl', 'car/.DS_Store', 'car/notes.txt'), {
    scene: 'car/car.OBJ',
    files: ['car/old/car.glb', 'car/car.OBJ', 'car/car.mtl'],
    leftOut: 2,
  });
  assert.equal(chosen('a.obj', 'a.gltf').scene, 'a.gltf');
  assert.deepEqual(chosen('sky.hdr', 'paint.png').files, ['sky.hdr']);
});

test('what cannot be taken is said before anything is sent', () => {
  assert.match(refused(files('a.glb'), null), /--uploads/);
  assert.match(refused(files('a.txt', '.a.glb')), /None of these is a scene/);
  assert.match(refused(files('a.glb', 'b.png', 'c.png', 'd.png')), /4 files; this server takes at most 3/);
  assert.match(refused([{ path: 'a.glb', bytes: 2 ** 20 + 1 }]), /2 MiB; this server takes at most 1 MiB/);
});

test('the head is the length of the list and the list', () => {
  const head = uploadHead('ä.glb', [{ path: 'ä.glb', bytes: 7 }]);
  const length = new DataView(head.buffer).getUint32(0, true);
  assert.equal(length, head.length - 4);
  const list: unknown = JSON.parse(new TextDecoder().decode(head.subarray(4)));
  assert.deepEqual(list, { scene: 'ä.glb', files: [{ path: 'ä.glb', bytes: 7 }] });
});

test('surroundings go around the scene that is shown, and replace others', () => {
  assert.equal(sceneToOpen(`upload/${ID}/a.glb`, 'cornell'), `upload/${ID}/a.glb`);
  assert.equal(sceneToOpen(`upload/${ID}/a.hdr`, 'cornell'), `cornell+upload/${ID}/a.hdr`);
  assert.equal(sceneToOpen(`upload/${ID}/b.hdr`, `cornell+upload/${ID}/a.hdr`), `cornell+upload/${ID}/b.hdr`);
  assert.equal(isUploaded(`upload/${ID}/a.glb`) && isUploaded(`cornell+upload/${ID}/a.hdr`), true);
  assert.equal(isUploaded('cornell') || isUploaded('upload/x/a.glb'), false);
  assert.equal(displayName(`upload/${ID}/car.glb`), 'Car.glb');
  assert.equal(displayName(`cornell+upload/${ID}/sky.hdr`), 'Cornell with sky.hdr');
});
