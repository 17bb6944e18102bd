// A page at a fake server, for the tests of the page alone.

import { get } from 'node:http';
import { join } from 'node:path';
import { Browser, freePort, outFolder, root, Server, unfoldFor, until } from './page.mjs';

const FAKE = join(root, 'tests/browser/fake_server.mjs');

/** A page at a fake server, with what the checks ask of both. */
export class Session {
  browser = new Browser();

  /** `fragment`: of the page's address. `shown`: waits for the picture. */
  async start(viewport, options = {}, environment = {}, fragment = '', shown = true) {
    this.server = new Server(await freePort(), 'cornell', FAKE, environment);
    await this.server.start();
    this.page = await this.browser.start(viewport, options);
    await this.page.goto(`http://127.0.0.1:${this.server.port}/${fragment}`);
    if (shown) await this.shown('cornell');
  }

  async stop() {
    await this.browser.stop();
    await this.server?.kill();
  }

  state = () => this.page.evaluate(() => window.heliograph.state);
  screenshot = (name) => this.page.screenshot({ path: join(outFolder, `${name}.png`) });
  field = (name) => this.page.locator(`[data-setting="${name}"]`);

  /** Waits until the scene and a picture of the newest input are on the screen. */
  async shown(name) {
    let seen = '';
    try {
      await until(`scene ${name}`, 20_000, async () => {
        const { scene, lastFrame, lastInputId, connection } = await this.state();
        const [frame, input] = [lastFrame?.inputId, lastInputId];
        seen = `${scene?.name} is ${scene?.state}, shown is input ${frame} of ${input}, the connection is ${connection.name}`;
        return scene?.name === name && scene.state === 'ready' && frame === input;
      });
    } catch (error) {
      throw new Error(`${error.message}: ${seen}`);
    }
  }

  async set(name, value) {
    await unfoldFor(this.page, name);
    const field = this.field(name);
    if ((await field.locator('select').count()) > 0) await field.locator('select').selectOption(value);
    else await field.locator('input[role=switch]').setChecked(value);
    await until(`the echo of ${name}`, 5000, async () => (await this.state()).settings[name] === value);
  }

  ask = (path) =>
    new Promise((done, failed) => {
      get({ host: '127.0.0.1', port: this.server.port, path }, (response) => {
        let text = '';
        response.on('data', (data) => (text += data));
        response.on('end', () => done(text));
      }).on('error', failed);
    });

  /** Messages of this type that the server got since it was last asked. */
  received = async (type) => JSON.parse(await this.ask('/received')).filter((message) => message.type === type);
}
