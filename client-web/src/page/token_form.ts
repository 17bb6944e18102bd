// Asks the viewer for the token of a server that wants one.

import { el } from './dom.js';

export class TokenForm {
  readonly element: HTMLFormElement;

  constructor(give: (token: string) => void) {
    const input = el('input', { type: 'password', id: 'token', autocomplete: 'current-password', required: true });
    this.element = el(
      'form',
      { class: 'token-form', hidden: true },
      el('label', { for: 'token' }, 'Token'),
      input,
      el('button', { type: 'submit', class: 'wide-button' }, 'Connect'),
    );
    this.element.addEventListener('submit', (event) => {
      event.preventDefault();
      const token = input.value.trim();
      input.value = '';
      if (token !== '') give(token);
    });
  }
}
