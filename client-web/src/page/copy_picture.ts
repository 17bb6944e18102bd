// The picture that is shown, into the clipboard.

/** False where the browser does not allow it: it needs https or this machine, and a page in front. */
export async function copyPicture(shown: HTMLCanvasElement): Promise<boolean> {
  if (!('ClipboardItem' in window) || !('clipboard' in navigator) || shown.width === 0) return false;
  const copy = document.createElement('canvas'); // the shown one hands its picture to nobody but a drawing
  copy.width = shown.width;
  copy.height = shown.height;
  copy.getContext('2d')?.drawImage(shown, 0, 0);
  const blob = new Promise<Blob>((done, failed) =>
    copy.toBlob((made) => (made === null ? failed(new Error('no picture')) : done(made)), 'image/png'),
  );
  try {
    await navigator.clipboard.write([new ClipboardItem({ 'image/png': blob })]); // at once, while the press still counts
    return true;
  } catch {
    return false;
  }
}
