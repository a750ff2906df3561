// A browser with the page in it, and a server for its files.
import { chromium } from 'playwright-core';
import { createServer } from 'node:http';
import { readFile, writeFile, mkdtemp, rm } from 'node:fs/promises';
import { spawnSync } from 'node:child_process';
import { existsSync } from 'node:fs';
import { setTimeout as sleep } from 'node:timers/promises';
import { tmpdir } from 'node:os';
import { extname, join } from 'node:path';
import assert from 'node:assert/strict';

const DIST = new URL('./dist/', import.meta.url).pathname;
export const PATIENCE = 120_000;
// Time limit for a test, milliseconds: more than ten times the longest one.
const LIMIT = 480_000;
const KINDS = {
  '.html': 'text/html', '.js': 'text/javascript', '.css': 'text/css', '.svg': 'image/svg+xml',
  '.wasm': 'application/wasm', '.webp': 'image/webp', '.webmanifest': 'application/manifest+json',
};
const BROWSERS = ['/usr/bin/chromium', '/usr/bin/google-chrome', '/usr/bin/chromium-browser'];
export const executable = process.env.MSD_CHROMIUM ?? BROWSERS.find(existsSync);

// Serves the files of the page on localhost.
export const serve = () => listen(async (request, response) => {
  const path = new URL(request.url, 'http://x').pathname.replace(/\/$/, '/index.html');
  try {
    const body = await readFile(join(DIST, path));
    response.writeHead(200, { 'content-type': KINDS[extname(path)] ?? 'text/plain' }).end(body);
  } catch {
    response.writeHead(404).end();
  }
});

// Returns the text of a built-in scene, with automatic substeps.
export async function automatic(scene) {
  const file = new URL(`../crates/msd-scene/scenes/${scene}.toml`, import.meta.url);
  return (await readFile(file, 'utf8')).replace(/^substeps = .*$/m, 'substeps = "auto"');
}

// Serves a page of another site, the same for each request.
export async function serveText(text) {
  const { server, url } = await listen((_, response) => {
    response.writeHead(200, { 'content-type': 'text/html' }).end(text);
  });
  return { server, url: url.replace('127.0.0.1', 'localhost') };
}

async function listen(answer) {
  const server = createServer(answer);
  await new Promise(ready => server.listen(0, '127.0.0.1', ready));
  return { server, url: `http://127.0.0.1:${server.address().port}/` };
}

// Returns the mean brightness of an image, 0 to 255, the share of coloured pixels, 0 to 1, and the
// mean red, green and blue; runs in a page. Bodies are coloured; ground and sky are not.
export async function survey(base64) {
  const image = await createImageBitmap(await (await fetch(`data:image/png;base64,${base64}`)).blob());
  const pen = new OffscreenCanvas(image.width, image.height).getContext('2d');
  pen.drawImage(image, 0, 0);
  const { data } = pen.getImageData(0, 0, image.width, image.height);
  const sums = [0, 0, 0];
  let coloured = 0;
  for (let at = 0; at < data.length; at += 4) {
    const [red, green, blue] = data.subarray(at, at + 3);
    [red, green, blue].forEach((part, at) => { sums[at] += part; });
    coloured += 60 < Math.max(red, green, blue) - Math.min(red, green, blue);
  }
  const means = sums.map(sum => 4 * sum / data.length);
  return [(means[0] + means[1] + means[2]) / 3, 4 * coloured / data.length, means];
}

// Both use software rendering. Without one of the four flags of the first the page is blank.
export const WAYS = {
  webgpu: ['--enable-unsafe-webgpu', '--enable-features=Vulkan', '--use-vulkan=swiftshader',
    '--use-angle=swiftshader'],
  webgl2: ['--use-angle=swiftshader', '--enable-unsafe-swiftshader'],
};

export class Page {
  static async open(executablePath, way, flags, url, view = { width: 960, height: 640 }) {
    const folder = await mkdtemp(join(tmpdir(), 'msd-web-'));
    const context = await chromium.launchPersistentContext(folder, {
      executablePath,
      headless: false,
      viewport: view,
      args: ['--headless=new', '--no-sandbox', '--disable-dev-shm-usage',
        '--disable-quic', '--no-first-run', '--disable-sync',
        '--disable-background-networking', '--disable-component-update', ...flags],
      permissions: ['clipboard-read', 'clipboard-write'],
    });
    if (!way.startsWith('webgpu')) {
      await context.addInitScript(() => { delete Navigator.prototype.gpu; });
    }
    const page = context.pages()[0];
    context.setDefaultTimeout(PATIENCE);
    const made = Object.assign(new Page(), { context, page, way, folder, url, said: [], asked: [] });
    made.cdp = await context.newCDPSession(page);
    page.on('console', message => made.said.push(`${message.type()}: ${message.text()}`));
    page.on('pageerror', error => made.said.push(`error: ${error.message}`));
    context.on('request', request => made.asked.push(request.url()));
    // Requests to a closed page may never be answered.
    made.gone = new Promise((_, lost) => {
      const say = () => { made.isLost = true; lost(new Error('the browser is gone')); };
      page.on('crash', say);
      context.on('close', say);
    });
    made.gone.catch(() => {});
    return made;
  }

  // Runs a test, unless the browser closes or does not respond for long.
  async pass(test) {
    let timer;
    const late = new Promise((_, lost) => {
      timer = setTimeout(() => {
        this.isLost = true;
        lost(new Error(`not done in ${LIMIT / 1000} s`));
      }, LIMIT);
    });
    await Promise.race([test(this), this.gone, late]).finally(() => clearTimeout(timer));
  }

  async go(fragment = '') {
    await this.page.goto('about:blank');
    await this.page.goto(this.url + fragment);
    await this.page.waitForFunction(
      () => ['running', 'missing'].includes(document.documentElement.dataset.state));
  }

  // Forgets open panels and the cameras of scenes. On a page without the program, which would store
  // them again.
  async forget() {
    await this.page.goto('about:blank');
    const { origin } = new URL(this.url);
    await this.cdp.send('Storage.clearDataForOrigin', { origin, storageTypes: 'local_storage' });
  }

  state() { return this.page.evaluate(() => document.documentElement.dataset.state); }

  status() { return this.page.evaluate(() => window.msd.status()); }

  // Two events in one frame would merge: a press and a jump would be a drag.
  async frames(count = 3) {
    await this.page.evaluate(count => new Promise(done => {
      const next = () => (count-- <= 0 ? done() : requestAnimationFrame(next));
      next();
    }), count);
  }

  // Converts a position on the canvas to one on the page.
  async place([x, y]) {
    const box = await this.page.locator('#canvas').boundingBox();
    return [box.x + x, box.y + y];
  }

  async drag(from, by, meanwhile = async () => {}) {
    const [x, y] = await this.place(from);
    const { mouse } = this.page;
    await mouse.move(x, y);
    await this.frames();
    await mouse.down();
    await this.frames();
    for (let step = 1; step <= 6; step++) {
      await mouse.move(x + by[0] * step / 6, y + by[1] * step / 6);
      await this.frames(2);
    }
    await this.frames();
    await meanwhile();
    await mouse.up();
    await this.frames();
  }

  // A short press: a slow frame in between would make it a long one.
  async click(place) {
    const [x, y] = await this.place(place);
    await this.page.mouse.move(x, y);
    await this.frames();
    await this.page.mouse.down();
    await this.page.mouse.up();
    await this.frames();
  }

  // Clicks the switch of the GPU, and returns the state after it.
  async switchGpu() {
    const { landmarks: { gpu: [left, top, , height] } } = await this.until('panels', now => now.landmarks.gpu);
    await this.click([left + 8, top + height / 2]);
    return this.status();
  }

  // Touches positions of the canvas with one finger each, without a release.
  async touch(...places) {
    const points = await Promise.all(places.map(place => this.place(place)));
    const touchPoints = points.map(([x, y], id) => ({ x, y, id }));
    const type = !touchPoints.length ? 'touchEnd' : this.isTouched ? 'touchMove' : 'touchStart';
    this.isTouched = touchPoints.length > 0;
    await this.cdp.send('Input.dispatchTouchEvent', { type, touchPoints });
  }

  // Moves the fingers from some positions to others.
  async swipe(from, to, meanwhile = async () => {}) {
    const between = part => from.map((place, finger) =>
      place.map((number, axis) => number + (to[finger][axis] - number) * part));
    // At once: a finger that rests during a slow frame is a long touch.
    await this.touch(...from);
    for (let step = 1; step <= 6; step++) {
      await this.touch(...between(step / 6));
      await this.frames(2);
    }
    await meanwhile();
    await this.touch();
    await this.frames();
  }

  async line(words) {
    await this.page.waitForFunction(
      words => document.getElementById('line').textContent.includes(words), words);
  }

  async link() {
    await this.page.click('#copy');
    await this.line('Copied: ');
    return this.page.evaluate(() => navigator.clipboard.readText());
  }

  async until(what, holds) {
    const start = Date.now();
    for (;;) {
      const now = await this.status();
      if (holds(now)) return now;
      assert(Date.now() - start < PATIENCE, `it never happens: ${what}`);
      await new Promise(next => setTimeout(next, 50));
    }
  }

  // Returns the share of coloured pixels in the middle of a view, 0 to 1.
  async coloured([left, top, width, height]) {
    return (await this.survey([left + width / 4, top + height / 4, width / 2, height / 2]))[1];
  }

  // Returns the `survey` of a rectangle of the canvas.
  async survey([left, top, width, height]) {
    const [x, y] = await this.place([left, top]);
    const clip = { x, y, width, height };
    const png = await this.page.screenshot({ clip });
    return this.page.evaluate(survey, png.toString('base64'));
  }

  async picture(name) {
    if (this.pictures) await this.page.screenshot({ path: join(this.pictures, `${name}.png`) });
  }

  // Takes a small screenshot for docs/.
  async photo(name) {
    if (!this.pictures) return;
    const png = await this.page.screenshot({ scale: 'css' });
    const webp = await this.page.evaluate(async base64 => {
      const image = await createImageBitmap(await (await fetch(`data:image/png;base64,${base64}`)).blob());
      const canvas = new OffscreenCanvas(image.width, image.height);
      canvas.getContext('2d').drawImage(image, 0, 0);
      const blob = await canvas.convertToBlob({ type: 'image/webp', quality: 0.75 });
      return [...new Uint8Array(await blob.arrayBuffer())];
    }, png.toString('base64'));
    await writeFile(join(this.pictures, `${name}.webp`), Uint8Array.from(webp));
  }

  // Asserts that there were no console messages, and no requests to other sites.
  check() {
    assert.deepEqual(this.said, [], 'messages on the console');
    const others = this.asked.filter(url => !url.startsWith(this.url) && !/^(data|blob|about):/.test(url));
    assert.deepEqual(others, [], 'requests to others');
  }

  async close() {
    const closed = this.context.close().then(() => true);
    if (!await Promise.race([closed, sleep(10_000, false, { ref: false })])) {
      spawnSync('pkill', ['-9', '-f', this.folder]);
    }
    await rm(this.folder, { recursive: true, force: true, maxRetries: 5 });
  }
}
