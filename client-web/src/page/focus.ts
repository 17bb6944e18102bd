// Where the focus goes: back to the picture once a button was clicked or a number was entered, so that the keys fly
// again. The picture shows a frame only where the Tab key brought the focus to it.

const FRAME = 'framed';

/** After a click by mouse or finger these have nothing more to take from the keyboard. */
const DONE_BY_CLICK = 'button, summary, input[type="checkbox"], input[type="radio"], input[type="range"], [role="slider"]';
/** These keep the focus, or have just given it to what they opened. */
const KEEPS = 'dialog, form, [role="menu"], [aria-haspopup], [aria-expanded="true"]:not(summary, .panel-head, .help-button)';

function afterClick(canvas: HTMLCanvasElement, event: MouseEvent): void {
  const byPointer = event.detail > 0;
  const control = event.target instanceof Element ? event.target.closest(DONE_BY_CLICK) : null;
  if (!byPointer || control === null || control.closest(KEEPS) !== null) return;
  const { activeElement } = document;
  if (activeElement === control || activeElement === document.body) canvas.focus({ preventScroll: true });
}

function afterKey(canvas: HTMLCanvasElement, event: KeyboardEvent): void {
  if (!(event.target instanceof Element) || event.target.getAttribute('role') !== 'spinbutton') return;
  if (event.key !== 'Enter' && event.key !== 'Escape') return;
  event.preventDefault();
  canvas.focus({ preventScroll: true }); // which tells the field that its value is meant
}

export function attachFocus(canvas: HTMLCanvasElement): void {
  let byTab = false;
  let byPointer = false; // the newest input
  const typed = (event: KeyboardEvent): void => {
    byTab ||= event.key === 'Tab';
    byPointer = false;
  };
  window.addEventListener('keydown', typed, { capture: true });
  window.addEventListener('keydown', (event) => afterKey(canvas, event));
  window.addEventListener(
    'pointerdown',
    () => {
      byTab = false;
      byPointer = true;
      canvas.classList.remove(FRAME);
    },
    { capture: true },
  );
  window.addEventListener('click', (event) => afterClick(canvas, event));
  window.addEventListener('change', ({ target }) => {
    const chosen = target instanceof HTMLSelectElement || (target instanceof HTMLInputElement && target.type === 'range');
    if (chosen && byPointer) canvas.focus({ preventScroll: true });
  });
  canvas.addEventListener('focus', () => canvas.classList.toggle(FRAME, byTab));
}
