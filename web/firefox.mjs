// Tests the page in Firefox through Marionette: node web/firefox.mjs [FOLDER], with screenshots in
// FOLDER. It needs a display: Firefox has no WebGL2 without one.
import { spawn } from 'node:child_process';
import { existsSync } from 'node:fs';
import { mkdtemp, readFile, rm, writeFile } from 'node:fs/promises';
import { connect } from 'node:net';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import assert from 'node:assert/strict';
import { PATIENCE, serve, survey } from './browser.mjs';

const executable = process.env.MSD_FIREFOX ?? ['/usr/bin/firefox-esr'].find(existsSync);

// Software rendering, a free port, and no requests to other sites.
const SETTINGS = {
  'marionette.port': 0,
  'webgl.force-enabled': true,
  'gfx.webgpu.ignore-blocklist': true,
  'app.normandy.enabled': false,
  'app.update.enabled': false,
  'browser.safebrowsing.malware.enabled': false,
  'browser.safebrowsing.phishing.enabled': false,
  'browser.shell.checkDefaultBrowser': false,
  'datareporting.policy.dataSubmissionEnabled': false,
  'network.captive-portal-service.enabled': false,
  'network.connectivity-service.enabled': false,
  'services.settings.server': '',
};

async function until(what, ask, patience = PATIENCE) {
  for (const start = Date.now(); ;) {
    const answer = await ask();
    if (answer) return answer;
    assert(Date.now() - start < patience, `it never happens: ${what}`);
    await new Promise(next => setTimeout(next, 50));
  }
}

// Marionette has two contexts, chrome and content. A message is its length in bytes, a colon and
// JSON: [0, id, name, parameters], with the response [1, id, error, result].
class Firefox {
  static async start(folder, settings, display) {
    const lines = Object.entries({ ...SETTINGS, ...settings })
      .map(([name, value]) => `user_pref(${JSON.stringify(name)}, ${JSON.stringify(value)});\n`);
    await writeFile(join(folder, 'user.js'), lines.join(''));
    const options = ['--no-remote', '--marionette', '--remote-allow-system-access', '--profile', folder];
    const env = { ...process.env, DISPLAY: display, LIBGL_ALWAYS_SOFTWARE: '1', MOZ_CRASHREPORTER_DISABLE: '1' };
    const program = spawn(executable, options, { stdio: 'ignore', env });
    const file = join(folder, 'MarionetteActivePort');
    const port = await until('a port', () => readFile(file, 'utf8').catch(() => ''));
    const socket = connect(Number(port), '127.0.0.1');
    const made = Object.assign(new Firefox(), { program, socket, asked: [], heard: Buffer.alloc(0) });
    socket.on('data', part => made.hear(part));
    // A closed Firefox does not answer.
    for (const end of ['error', 'close']) {
      socket.on(end, () => made.asked.forEach(({ failed }) => failed(new Error('Firefox is gone'))));
    }
    await made.ask('WebDriver:NewSession', {});
    await made.ask('WebDriver:SetTimeouts', { script: PATIENCE, pageLoad: PATIENCE });
    return made;
  }

  hear(part) {
    this.heard = Buffer.concat([this.heard, part]);
    for (;;) {
      const colon = this.heard.indexOf(':');
      const end = colon + 1 + Number(this.heard.subarray(0, Math.max(colon, 0)).toString());
      if (colon < 0 || this.heard.length < end) return;
      const message = JSON.parse(this.heard.subarray(colon + 1, end).toString());
      this.heard = this.heard.subarray(end);
      // The first message is a greeting.
      if (!Array.isArray(message)) continue;
      const [, id, error, result] = message;
      const { done, failed } = this.asked[id];
      if (error) failed(new Error(`${error.error}: ${error.message}`));
      else done(result);
    }
  }

  ask(name, parameters) {
    return new Promise((done, failed) => {
      const text = JSON.stringify([0, this.asked.push({ done, failed }) - 1, name, parameters]);
      this.socket.write(`${Buffer.byteLength(text)}:${text}`);
    });
  }

  // Returns the value of an expression in the page, or of its promise.
  async evaluate(expression) {
    const script = `const end = arguments[arguments.length - 1];
      Promise.resolve(${expression}).then(value => end([value]), error => end([null, String(error)]));`;
    const { value: [value, error] } = await this.ask('WebDriver:ExecuteAsyncScript', { script, sandbox: null });
    if (error) throw new Error(error);
    return value;
  }

  status() { return this.evaluate('window.msd.status()'); }

  // Returns once the page shows a picture; a change of the fragment alone would not load the page.
  async go(url) {
    await this.ask('WebDriver:Navigate', { url: 'about:blank' });
    await this.ask('WebDriver:Navigate', { url });
    await until('a picture', () => this.evaluate('/running|missing/.test(document.documentElement.dataset.state)'));
  }

  act(source) { return this.ask('WebDriver:PerformActions', { actions: [source] }); }

  press(value) {
    return this.act({ type: 'key', id: 'keys', actions: [{ type: 'keyDown', value }, { type: 'keyUp', value }] });
  }

  // Returns the console errors and warnings of pages at an address.
  async said(url) {
    await this.ask('Marionette:SetContext', { value: 'chrome' });
    const script = `const { classes: Cc, interfaces: Ci } = Components;
      const storage = Cc['@mozilla.org/consoleAPI-storage;1'].getService(Ci.nsIConsoleAPIStorage);
      const errors = Services.console.getMessageArray()
        .filter(message => message instanceof Ci.nsIScriptError && message.sourceName.startsWith(arguments[0]));
      const calls = storage.getEvents().filter(({ filename }) => filename.startsWith(arguments[0]));
      return [...errors.map(error => error.errorMessage), ...calls.map(call => call.arguments.join(' '))];`;
    const { value } = await this.ask('WebDriver:ExecuteScript', { script, args: [url] });
    await this.ask('Marionette:SetContext', { value: 'content' });
    return value;
  }

  async picture() { return (await this.ask('WebDriver:TakeScreenshot', { full: false })).value; }
}

// The first actions of a visitor.
async function visit(firefox, way, url) {
  await firefox.go(`${url}#scene=cube&embed`);
  await until('steps', async () => 5 < (await firefox.status()).steps);
  const picture = await firefox.picture();
  if (process.argv[2]) await writeFile(join(process.argv[2], `firefox-${way}.png`), picture, 'base64');
  const [, coloured] = await firefox.evaluate(`(${survey})("${picture}")`);
  assert(0.02 < coloured, `${coloured} of the picture has a colour`);
  await firefox.press(' ');
  const { steps, aim: { screen: [x, y] } } = await until('a pause', async () => {
    const now = await firefox.status();
    return now.paused && now;
  });
  const at = (x, y) => ({ type: 'pointerMove', x: Math.round(x), y: Math.round(y), duration: 300 });
  const actions = [at(x, y), { type: 'pointerDown', button: 0 }, at(x + 60, y - 80)];
  await firefox.act({ type: 'pointer', id: 'mouse', parameters: { pointerType: 'mouse' }, actions });
  await until('a grab', async () => (await firefox.status()).held !== null);
  assert.equal((await firefox.status()).steps, steps, 'paused');
  await firefox.ask('WebDriver:ReleaseActions', {});
  await until('a release', async () => (await firefox.status()).held === null);
  await firefox.press(' ');
  await until('going on', async () => steps + 5 < (await firefox.status()).steps);
}

// Changes the pixel ratio as another screen would. Chromium's emulation changes only the number,
// not the pixels of a canvas or the result of media queries.
async function rescale(firefox, _, url) {
  await firefox.go(`${url}#scene=cube&embed`);
  await until('steps', async () => 5 < (await firefox.status()).steps);
  for (const ratio of [2, 1.5, 1]) {
    await firefox.ask('Marionette:SetContext', { value: 'chrome' });
    const script = "Services.prefs.setStringPref('layout.css.devPixelsPerPx', String(arguments[0]));";
    await firefox.ask('WebDriver:ExecuteScript', { script, args: [ratio] });
    await firefox.ask('Marionette:SetContext', { value: 'content' });
    const sizes = `(({ width, height, clientWidth, clientHeight }) =>
      [devicePixelRatio, width, clientWidth, height, clientHeight])(document.getElementById('canvas'))`;
    await until(`${ratio} pixels for one of CSS`, async () => {
      const [now, width, wide, height, high] = await firefox.evaluate(sizes);
      return now === ratio && Math.abs(width - ratio * wide) <= 1 && Math.abs(height - ratio * high) <= 1;
    });
    await until('as much room', async () => {
      const { view: [, , width] } = await firefox.status();
      return Math.abs(width - (await firefox.evaluate(sizes))[2]) <= 1;
    });
  }
}

// Steps on the graphics card.
async function gpu(firefox, _, url) {
  await firefox.go(`${url}#scene=cloth`);
  const { landmarks: { gpu: [left, top, , height] } } =
    await until('panels', async () => (now => now.landmarks.gpu && now)(await firefox.status()));
  const { x, y } = await firefox.evaluate('(({ x, y }) => ({ x, y }))(document.getElementById("canvas").getBoundingClientRect())');
  const at = { type: 'pointerMove', x: Math.round(x + left + 8), y: Math.round(y + top + height / 2), duration: 300 };
  const actions = [at, { type: 'pointerDown', button: 0 }, { type: 'pointerUp', button: 0 }];
  await firefox.act({ type: 'pointer', id: 'mouse', parameters: { pointerType: 'mouse' }, actions });
  const { refusal } = await until('checked steps', async () => {
    const now = await firefox.status();
    return (now.refusal || 30 < now.gpu?.steps && 0 < now.gpu.checked) && now;
  });
  if (process.argv[2]) await writeFile(join(process.argv[2], 'firefox-gpu.png'), await firefox.picture(), 'base64');
  assert.equal(refusal, null);
}

async function verify(firefox, _, url) {
  await firefox.go(`${url}#scene=chain&embed&verify`);
  await firefox.press(' ');
  const verified = () => firefox.evaluate('document.documentElement.dataset.verified ?? ""');
  const line = await until('hashes', verified, 5 * PATIENCE);
  assert.match(line, /^all \d+ runs match the reference bits/);
}

if (!executable || !existsSync('/usr/bin/Xvfb')) {
  console.log('web-test: SKIPPED Firefox (install it with: apt install firefox-esr xvfb)');
  process.exit(process.env.MSD_REQUIRE_FIREFOX ? 1 : 0);
}
const { server, url } = await serve();
const screen = spawn('Xvfb', ['-displayfd', '3', '-screen', '0', '1280x900x24'],
  { stdio: ['ignore', 'ignore', 'ignore', 'pipe'] });
const display = `:${(await new Promise(heard => screen.stdio[3].once('data', heard))).toString().trim()}`;
let failed = 0;
for (const [way, test] of [
  ['webgpu', visit], ['webgl2', visit], ['webgpu', rescale], ['webgl2', rescale], ['webgl2', verify],
  ['webgpu', gpu],
]) {
  const folder = await mkdtemp(join(tmpdir(), 'msd-firefox-'));
  const start = Date.now();
  const firefox = await Firefox.start(folder, { 'dom.webgpu.enabled': way === 'webgpu' }, display);
  try {
    await test(firefox, way, url);
    // From wgpu, which requests a name that Firefox has deprecated.
    const said = (await firefox.said(url)).filter(line => !line.startsWith('WEBGL_debug_renderer_info'));
    assert.deepEqual(said, [], 'messages on the console');
    console.log(`ok  Firefox, ${way}: ${test.name} (${Date.now() - start} ms)`);
  } catch (error) {
    failed += 1;
    console.log(`BAD Firefox, ${way}: ${test.name}\n${error.stack}`);
  }
  const gone = new Promise(gone => firefox.program.once('exit', gone));
  firefox.program.kill();
  await gone;
  await rm(folder, { recursive: true, force: true });
}
screen.kill();
server.close();
process.exit(failed ? 1 : 0);
