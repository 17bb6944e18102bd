// What a person would see of the page, as figures.

import { readFileSync } from 'node:fs';
import { expect } from './page.mjs';

/** Mean and spread (0..255) of the picture on the canvas, and a coarse copy of it to compare. */
export const picture = (page) =>
  page.evaluate(() => {
    const canvas = document.querySelector('body > canvas');
    const copy = document.createElement('canvas');
    [copy.width, copy.height] = [64, 36];
    const context = copy.getContext('2d');
    context.drawImage(canvas, 0, 0, 64, 36);
    const { data } = context.getImageData(0, 0, 64, 36);
    const values = Array.from({ length: 64 * 36 }, (_, i) => (data[4 * i] + data[4 * i + 1] + data[4 * i + 2]) / 3);
    const mean = values.reduce((sum, value) => sum + value, 0) / values.length;
    const spread = Math.sqrt(values.reduce((sum, value) => sum + (value - mean) ** 2, 0) / values.length);
    return { mean, spread, values, width: canvas.width, height: canvas.height };
  });

/** Mean difference of two pictures, 0..255. */
export const difference = (a, b) =>
  a.values.reduce((sum, value, i) => sum + Math.abs(value - b.values[i]), 0) / a.values.length;

/** Pixels of the canvas that differ from those of a PNG file, and how many there are. */
export const compared = (page, png) =>
  page.evaluate(async (base64) => {
    const bytes = Uint8Array.from(atob(base64), (c) => c.charCodeAt(0));
    const options = { colorSpaceConversion: 'none', premultiplyAlpha: 'none' };
    const image = await createImageBitmap(new Blob([bytes], { type: 'image/png' }), options);
    const canvas = document.querySelector('body > canvas');
    const pixelsOf = (source) => {
      const copy = new OffscreenCanvas(source.width, source.height);
      const context = copy.getContext('2d');
      context.drawImage(source, 0, 0);
      return context.getImageData(0, 0, source.width, source.height).data;
    };
    const [shown, saved] = [pixelsOf(canvas), pixelsOf(image)];
    let different = 0;
    for (let i = 0; i < saved.length; i += 4)
      different += shown[i] !== saved[i] || shown[i + 1] !== saved[i + 1] || shown[i + 2] !== saved[i + 2];
    return { different, pixels: saved.length / 4, same: shown.length === saved.length };
  }, png.toString('base64'));

/** The picture that F3 saves. */
export async function savedPicture(page) {
  const download = page.waitForEvent('download');
  await page.keyboard.press('F3');
  return readFileSync(await (await download).path());
}

/** Text and box of every visible control that has no name or lies outside the window. */
export const badControls = (page) =>
  page.evaluate(() => {
    const bad = [];
    for (const control of document.querySelectorAll('button, input, select, summary, canvas[tabindex]')) {
      const box = control.getBoundingClientRect();
      if (box.width === 0 || getComputedStyle(control).visibility === 'hidden') continue;
      const name = control.getAttribute('aria-label') ?? control.labels?.[0]?.textContent ?? control.textContent ?? '';
      if (name.trim() === '') bad.push(`no name: ${control.outerHTML.slice(0, 120)}`);
      if (box.left < -1 || box.right > innerWidth + 1) bad.push(`outside: ${name} ${box.left} to ${box.right}`);
    }
    return bad;
  });

/** Texts of bars, panels, cards and dialogs whose contrast is below 4.5:1, over a black or a white picture. */
export const lowContrast = (page) =>
  page.evaluate(() => {
    const parsed = (color) => {
      const [r, g, b, a = 1] = color.match(/[\d.]+/g).map(Number);
      return { rgb: [r, g, b], a };
    };
    const over = ({ rgb, a }, below) => below.map((value, i) => a * rgb[i] + (1 - a) * value);
    const linear = (value) => (value <= 10.31 ? value / 3294.6 : ((value / 255 + 0.055) / 1.055) ** 2.4);
    const luminance = (rgb) => rgb.reduce((sum, value, i) => sum + [0.2126, 0.7152, 0.0722][i] * linear(value), 0);
    const contrast = (a, b) => (Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05);
    const found = new Set();
    const texts = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
    for (let node = texts.nextNode(); node !== null; node = texts.nextNode()) {
      const element = node.parentElement;
      if (node.data.trim() === '' || element.closest('.bar, .panel, .toast, .menu, .map-card, dialog') === null) continue;
      const box = element.getBoundingClientRect();
      if (box.width < 2 || box.height < 2 || !element.checkVisibility({ visibilityProperty: true })) continue;
      if (element.closest(':disabled, [aria-disabled=true], option, .disabled') !== null) continue; // needs none (WCAG 1.4.3)
      const layers = [];
      for (let at = element; at !== null && at !== document.body; at = at.parentElement) layers.unshift(getComputedStyle(at));
      const lowest = Math.min(...[[0, 0, 0], [255, 255, 255]].map((picture) => {
        const ground = layers.reduce((below, style) => over(parsed(style.backgroundColor), below), picture);
        return contrast(luminance(over(parsed(layers.at(-1).color), ground)), luminance(ground));
      }));
      if (lowest < 4.5) found.add(`${lowest.toFixed(2)}:1 for "${node.data.trim().slice(0, 40)}"`);
    }
    return [...found];
  });

/** Pairs of bars, panels and cards that cover each other. */
export const overlaps = (page) =>
  page.evaluate(() => {
    const boxes = [...document.querySelectorAll('.bar, .panel, .map-card')]
      .map((element) => ({ name: element.id || element.className, box: element.getBoundingClientRect() }))
      .filter(({ box }) => box.width > 0);
    const found = [];
    for (const [i, a] of boxes.entries()) {
      for (const b of boxes.slice(i + 1)) {
        const across = Math.min(a.box.right, b.box.right) - Math.max(a.box.left, b.box.left);
        const down = Math.min(a.box.bottom, b.box.bottom) - Math.max(a.box.top, b.box.top);
        if (across > 0 && down > 0) found.push(`${a.name} and ${b.name}`);
      }
    }
    return found;
  });

/** Size that a PNG file states; throws when it is none. */
export function pngSize(bytes) {
  expect(
    bytes.subarray(0, 8).equals(Buffer.from([0x89, 0x50, 0x4e, 0x47, 0x0d, 0x0a, 0x1a, 0x0a])),
    'no PNG signature',
  );
  expect(bytes.subarray(12, 16).toString('latin1') === 'IHDR', 'no IHDR chunk');
  return { width: bytes.readUInt32BE(16), height: bytes.readUInt32BE(20) };
}
