// Tests the page in Chromium, with WebGPU and with WebGL2: node web/test.mjs [FOLDER], with
// screenshots in FOLDER.
import { readFile, writeFile } from 'node:fs/promises';
import { execFileSync } from 'node:child_process';
import { existsSync } from 'node:fs';
import { join } from 'node:path';
import assert from 'node:assert/strict';
import { PATIENCE, Page, WAYS, automatic, executable, serve, serveText } from './browser.mjs';

// A scene that is not built in.
const OWN = `version = 1
[[bodies]]
kind = "block"
size = [2, 2, 2]
stiffness = 123
`;

// Soft and without gravity, so that a released particle does not swing back at once.
const FREE = `version = 1
[world]
gravity = [0, 0, 0]
[[bodies]]
kind = "block"
size = [2, 2, 2]
stiffness = 50
`;

// The program that `scripts/check.sh test` builds, which must come to the same bits.
function desktop() {
  const msd = new URL('../target/debug/msd', import.meta.url).pathname;
  if (existsSync(msd)) return msd;
  assert(!process.env.MSD_REQUIRE_BROWSER, `${msd} is not built`);
  console.log('    SKIPPED beside the desktop (build it with: cargo build --bin msd)');
}

const tests = {
  async 'the body is drawn'(page) {
    await page.go('#scene=cube');
    assert.equal(await page.state(), 'running');
    const first = await page.page.evaluate(() => document.documentElement.dataset.first);
    console.log(`    first picture after ${Math.round(first)} ms`);
    const { view } = await page.until('steps', now => 5 < now.steps);
    await page.picture('running');
    if (page.way === 'webgpu') await page.photo('browser');
    const coloured = await page.coloured(view);
    assert(0.1 < coloured, `${coloured} of the middle has a colour`);
  },

  async 'Space pauses'(page) {
    await page.go('#scene=jelly');
    await page.until('steps', now => 2 < now.steps);
    await page.page.keyboard.press('Space');
    const paused = await page.until('a pause', now => now.paused);
    await page.frames(6);
    assert.equal((await page.status()).steps, paused.steps);
    await page.page.keyboard.press('Space');
    await page.until('going on', now => paused.steps < now.steps);
  },

  async 'a drag moves the particle that it grabs'(page) {
    await page.go('#scene=cloth');
    await page.until('steps', now => 2 < now.steps);
    await page.page.keyboard.press('Space');
    const { aim } = await page.until('a pause', now => now.paused);
    let before;
    await page.drag(aim.screen, [60, -80], async () => {
      before = await page.status();
      assert.notEqual(before.held, null, 'something is held');
      await page.page.keyboard.press('Space');
      const after = await page.until('steps', now => before.steps + 20 < now.steps);
      const distance = (a, b) => Math.hypot(...a.map((number, axis) => number - b[axis]));
      const [far, near] = [before, after].map(now => distance(now.held_position, now.held_target));
      assert(near < 0.5 * far, `${far} m and then ${near} m from the hand`);
    });
    await page.until('a release', now => now.held === null);
  },

  // Paused, step by step: a speed would vary with the frames.
  async 'what is let go in motion flies on'(page) {
    await page.go('#scene=chain');
    await page.page.setInputFiles('#open', { name: 'free.toml', mimeType: '', buffer: Buffer.from(FREE) });
    await page.until('the scene', now => now.scene === 'free' && 2 < now.steps);
    await page.page.click('[data-command=pause]');
    await page.until('a pause', now => now.paused);
    await page.page.click('[data-command=restart]');
    await page.page.focus('#canvas');
    const { aim } = await page.until('the start', now => now.steps === 0);
    const where = async () => (await page.page.evaluate(at => window.msd.msd.position(at), aim.particle))
      .split(' ').map(Number);
    const step = async count => {
      for (let { steps } = await page.status(); 0 < count; count--) {
        await page.page.keyboard.press('.');
        steps += 1;
        await page.until('a step', now => now.steps === steps);
      }
    };
    const minus = (a, b) => a.map((number, axis) => number - b[axis]);
    const start = await where();
    let way, left;
    await page.drag(aim.screen, [40, -160], async () => {
      const held = await page.status();
      assert.equal(held.held, aim.particle);
      way = minus(held.held_target, start);
      await step(4);
      left = await where();
    });
    const { held, steps } = await page.status();
    assert.deepEqual([held, steps], [null, 4]);
    await step(2);
    const length = Math.hypot(...way);
    const along = to => minus(to, start).reduce((sum, number, axis) => sum + number * way[axis], 0) / length;
    const [pulled, flown] = [left, await where()].map(along);
    assert(0.02 < pulled && pulled < length, `${pulled} m of ${length} m`);
    assert(1.2 * pulled < flown, `let go after ${pulled} m, it is at ${flown} m`);
  },

  async 'automatic substeps are chosen as on the desktop, at the start and after a change'(page) {
    await page.go('#scene=chain');
    const name = 'bunny.toml';
    const text = await automatic('bunny');
    await page.page.setInputFiles('#open', { name, mimeType: '', buffer: Buffer.from(text) });
    const first = await page.until('the scene', now => now.scene === 'bunny' && 5 < now.steps);
    assert.equal(first.solver.automatic, true);
    await page.page.click('[data-command=pause]');
    const { steps, landmarks, solver } = await page.until('a pause', now => now.paused);
    const [download] = await Promise.all([page.page.waitForEvent('download'), page.page.click('#save')]);
    const msd = desktop();
    if (msd) {
      const [saved, written] = ['bunny.msd', name].map(file => join(page.folder, file));
      await download.saveAs(saved);
      await writeFile(written, text);
      const hash = (file, frames) => JSON.parse(execFileSync(
        msd, ['run', file, '--duration', `${frames / 60}`, '--json'])).state_hash;
      assert.equal(hash(saved, 30), hash(written, steps + 30));
    }
    const [left, top, , height] = landmarks.stiffness;
    await page.drag([left + 40, top + height / 2], [20, 0]);
    const other = await page.until('others', ({ solver: { substeps } }) =>
      substeps !== null && substeps !== solver.substeps);
    assert(solver.substeps < other.solver.substeps, 'stiffer springs need more');
    await page.page.click('[data-command=pause]');
    await page.until('steps', now => steps + 5 < now.steps);
  },

  async 'the canvas follows the window and its place in the page'(page) {
    await page.go('#scene=cube');
    // A moving particle may be elsewhere by the frame of the press.
    await page.page.click('[data-command=pause]');
    await page.until('a pause', now => now.paused);
    for (const [width, height, part] of [[640, 480, 1], [1100, 700, 0.75], [960, 640, 1]]) {
      await page.page.setViewportSize({ width, height });
      await page.page.evaluate(part => {
        Object.assign(document.querySelector('main').style, { flex: 'auto', width: `${100 * part}%` });
      }, part);
      await page.page.waitForFunction(wide => {
        const { width, height, clientWidth, clientHeight } = document.getElementById('canvas');
        return clientWidth === wide && width === devicePixelRatio * clientWidth
          && height === devicePixelRatio * clientHeight;
      }, part * width);
      // Until the next frame the window reports its old place.
      await page.frames();
      const { aim, view: [left, , wide] } = await page.status();
      assert.equal(left + wide + 292, part * width, 'the panel of numbers ends at the edge');
      await page.drag(aim.screen, [30, -30], () => page.until('a grab', now => now.held !== null));
    }
  },

  async 'in a page of another origin it runs, and can be grabbed'(page) {
    const { server, url } = await serveText(
      `<iframe src="${page.url}#scene=cloth&embed" style="width: 700px; height: 500px; border: 0"></iframe>`);
    await page.page.goto(url);
    const frame = await (await page.page.waitForSelector('iframe')).contentFrame();
    await frame.waitForFunction(() => document.documentElement.dataset.state === 'running');
    const until = holds => frame.waitForFunction(
      async holds => Function('now', `return ${holds}`)(await window.msd.status()), holds);
    await until('2 < now.steps');
    await frame.focus('#canvas');
    await page.page.keyboard.press('Space');
    await until('now.paused');
    const { aim: { screen: [x, y] }, view } = await frame.evaluate(() => window.msd.status());
    assert.deepEqual(view, [0, 0, 700, 500]);
    const box = await page.page.locator('iframe').boundingBox();
    await page.page.mouse.move(box.x + x, box.y + y);
    await page.page.mouse.down();
    await until('now.held !== null');
    await page.page.mouse.up();
    await until('now.held === null');
    server.close();
    page.asked = page.asked.filter(asked => !asked.startsWith(url));
  },

  async 'a slider changes the stiffness'(page) {
    await page.go('#scene=cloth');
    const before = await page.until('steps', now => 2 < now.steps);
    const [left, top, width, height] = before.landmarks.stiffness;
    await page.drag([left + 0.3 * width, top + height / 2], [25, 0]);
    const after = await page.status();
    assert.notEqual(after.stiffness, before.stiffness);
  },

  async 'a link restores scene, settings and camera'(page) {
    await page.go('#scene=cloth');
    const before = await page.until('steps', now => 2 < now.steps);
    const [left, top, width, height] = before.landmarks.stiffness;
    // Softer: a stiffer cloth would diverge and pause.
    await page.drag([left + 0.3 * width, top + height / 2], [-8, 0]);
    const [x, y, , tall] = before.view;
    await page.drag([x + 30, y + tall - 60], [70, 10]);
    const made = await page.status();
    assert.notEqual(made.camera.yaw, before.camera.yaw, 'the camera turned');
    await page.page.click('#copy');
    const link = await page.page.evaluate(() => navigator.clipboard.readText());
    assert(link.startsWith(`${page.url}#scene=cloth&with=`), link);
    assert(link.length < 300, link);
    await page.go(link.slice(page.url.length));
    const again = await page.until('steps', now => 2 < now.steps);
    assert.equal(again.stiffness, made.stiffness);
    assert.equal(again.camera.yaw, made.camera.yaw);
    assert.equal(again.camera.distance, made.camera.distance);
  },

  async 'a damaged link says so and shows the first scene'(page) {
    for (const [fragment, words] of [
      ['#scene=cloth&with=AwIDBAUGBw', 'damaged'],
      ['#scene=cloth&with=Y2NjY2NjY2M', 'another version'],
      ['#scene=nothing', 'unknown scene'],
    ]) {
      await page.go(fragment);
      assert.equal((await page.status()).scene, 'cube');
      assert.match(await page.page.textContent('#line'), new RegExp(words));
    }
  },

  async 'a link holds a scene of ones own, or says which file is too large'(page) {
    await page.go('#scene=chain');
    await page.page.setInputFiles('#open', { name: 'two words.toml', mimeType: '', buffer: Buffer.from(OWN) });
    await page.until('the scene', now => now.scene === 'two words');
    const link = await page.link();
    assert(link.startsWith(`${page.url}#scene=own&file=`) && link.length < 1000, link);
    await page.go(link.slice(page.url.length));
    const again = await page.until('steps', now => 2 < now.steps);
    assert.deepEqual([again.scene, again.stiffness], ['two words', 123]);
    await page.page.evaluate(() => { location.hash = '#scene=jelly'; });
    await page.until('another scene', now => now.scene === 'jelly');
    await page.go('#scene=own&file=AQIDBAUGBw');
    assert.match(await page.page.textContent('#line'), /damaged.*here is cube instead/);
    const noise = Array.from({ length: 10_000 }, () => `# ${Math.random()} ${Math.random()}`);
    const large = Buffer.from([OWN, ...noise].join('\n'));
    await page.page.setInputFiles('#open', { name: 'large.toml', mimeType: '', buffer: large });
    await page.until('the scene', now => now.scene === 'large');
    await page.page.click('#copy');
    await page.line('large.toml is too large for a link');
  },

  async 'a lost graphics device is replaced, and the run goes on from where it was'(page) {
    await page.go('#scene=cube');
    await page.until('steps', now => 5 < now.steps);
    await page.page.keyboard.press('Space');
    const before = await page.until('a pause', now => now.paused);
    await page.page.evaluate(way => {
      if (way === 'webgpu') return window.msd.msd.lose_device();
      const canvas = document.getElementById('canvas');
      const loss = canvas.getContext('webgl2').getExtension('WEBGL_lose_context');
      canvas.addEventListener('webglcontextlost', () => setTimeout(() => loss.restoreContext(), 300));
      loss.loseContext();
    }, page.way);
    // The line about the wait for another device may last less than a frame.
    await page.line('graphics device was lost');
    await page.line('rendering resumed');
    await page.frames();
    const after = await page.status();
    assert.deepEqual([after.steps, after.paused], [before.steps, true]);
    assert.deepEqual([after.camera.yaw, after.camera.distance], [before.camera.yaw, before.camera.distance]);
    // The new pipelines may take some frames.
    let coloured = 0;
    for (let tries = 0; coloured <= 0.1 && tries < 20; tries++) {
      await page.frames();
      coloured = await page.coloured(after.view);
    }
    assert(0.1 < coloured, `${coloured} of the middle has a colour`);
    await page.picture('drawn-again');
    await page.page.keyboard.press('Space');
    await page.until('going on', now => before.steps + 5 < now.steps);
    // The browser reports the loss, and the use of objects of the old context.
    const own = /CONTEXT_LOST|context lost|device lost|does not belong to this context/i;
    page.said = page.said.filter(line => !own.test(line));
  },

  async 'a look that is chosen in the panel is seen'(page) {
    await page.page.setViewportSize({ width: 960, height: 1200 });
    await page.go('#scene=cube');
    await page.until('steps', now => 2 < now.steps);
    await page.page.click('[data-command=pause]');
    const { landmarks, view, steps } = await page.until('a pause', now => now.paused);
    const middle = ([left, top, width, height]) => [left + width / 2, top + height / 2];
    await page.click(middle(landmarks.look));
    const { landmarks: { colour } } = await page.until('looks', now => now.landmarks.colour);
    const inner = [view[0] + view[2] / 4, view[1] + view[3] / 4, view[2] / 2, view[3] / 2];
    const [red, green] = (await page.survey(inner))[2];
    assert(green + 10 < red, `red at first: ${red} and ${green}`);
    await page.click(middle(colour));
    await page.frames(6);
    // The picker opens below the field, right-aligned; the sixth colour from its end is a green.
    await page.click([colour[0] + colour[2] - 19 - 5 * 26, colour[1] + colour[3] + 19]);
    await page.frames(6);
    await page.picture('look');
    const [less, more] = (await page.survey(inner))[2];
    assert(less + 10 < more, `green afterwards: ${less} and ${more}`);
    assert.equal((await page.status()).steps, steps);
    await page.page.setViewportSize({ width: 960, height: 640 });
  },

  async 'the theme outlasts a reload'(page) {
    await page.page.setViewportSize({ width: 960, height: 1200 });
    for (const light of [true, false]) {
      await page.go('#scene=chain');
      const { landmarks } = await page.until('panels', now => now.landmarks.light);
      const [left, top, width, height] = landmarks.light;
      await page.click([left + 8, top + height / 2]);
      await page.page.waitForFunction(
        light => JSON.parse(localStorage['msd.preferences'] ?? '{}').light === light, light);
      await page.go('#scene=chain');
      await page.frames(6);
      const [brightness] = await page.survey([left - 4, top - 4, width + 8, height + 8]);
      assert.equal(120 < brightness, light, `${brightness}`);
    }
    await page.page.setViewportSize({ width: 960, height: 640 });
  },

  async 'a finger grabs or turns, two zoom and pan, a long touch pins'(page) {
    await page.go('#scene=cloth');
    await page.until('steps', now => 2 < now.steps);
    await page.page.keyboard.press('Space');
    const { aim, view: [left, top, width, height], pins } = await page.until('a pause', now => now.paused);
    const [x, y] = aim.screen;
    await page.swipe([[x, y]], [[x + 60, y - 60]], () => page.until('a grab', now => now.held !== null));
    const before = await page.until('a release', now => now.held === null);
    const [besideX, besideY] = [left + 30, top + height - 40];
    await page.swipe([[besideX, besideY]], [[besideX + 90, besideY - 12]]);
    const turned = await page.status();
    assert.notEqual(turned.camera.yaw, before.camera.yaw, 'the camera turned');
    assert.equal(turned.pins, pins);
    await page.touch(turned.aim.screen);
    await page.until('a pin', now => now.pins !== pins);
    await page.touch();
    await page.frames();
    const at = (x, y) => [left + width / 2 + x, top + height / 2 + y];
    await page.swipe([at(-30, 0), at(30, 0)], [at(-90, 0), at(90, 0)]);
    const near = await page.status();
    assert(near.camera.distance < 0.6 * turned.camera.distance, `${near.camera.distance} m away`);
    await page.swipe([at(-30, 0), at(30, 0)], [at(-30, 80), at(30, 80)]);
    const panned = await page.status();
    assert.notDeepEqual(panned.camera.target, near.camera.target, 'the camera moved');
  },

  async 'a hidden page is paused and catches nothing up'(page) {
    await page.go('#scene=chain');
    await page.until('steps', now => 2 < now.steps);
    const see = state => page.page.evaluate(state => {
      Object.defineProperty(document, 'visibilityState', { value: state, configurable: true });
      document.dispatchEvent(new Event('visibilitychange', { bubbles: true }));
    }, state);
    await see('hidden');
    // A frame in progress ends.
    await page.frames(6);
    const before = await page.status();
    await new Promise(next => setTimeout(next, 3000));
    assert.equal((await page.status()).steps, before.steps);
    await see('visible');
    const after = await page.until('going on', now => before.steps < now.steps);
    // At most a slow frame or two, not the 180 steps of three seconds.
    assert(after.steps < before.steps + 90, `${after.steps - before.steps} steps`);
  },

  async 'a file that is too large is refused before it is read'(page) {
    await page.go('#scene=chain');
    await page.page.evaluate(() => {
      File.prototype.arrayBuffer = () => { throw new Error('it was read'); };
      const dataTransfer = new DataTransfer();
      const part = new Uint8Array(1e6);
      dataTransfer.items.add(new File(Array(201).fill(part), 'large.obj'));
      document.body.dispatchEvent(new DragEvent('drop', { dataTransfer, bubbles: true, cancelable: true }));
    });
    await page.line('large.obj: too large for a browser, 201 MB of at most 200 MB');
    assert.equal((await page.status()).scene, 'chain');
  },

  async 'scenes are opened in a worker, from the list of the page and from that of the window'(page) {
    await page.go('#scene=chain');
    await page.until('steps', now => 2 < now.steps);
    const workers = [];
    page.page.on('worker', worker => workers.push(worker.url().split('/').at(-1)));
    await page.page.selectOption('#scene', 'square');
    await page.until('the scene', now => now.scene === 'square');
    await page.page.focus('#canvas');
    await page.page.keyboard.press('2');
    await page.until('the second scene', now => now.scene === 'jelly');
    assert.deepEqual(workers, ['beside.js', 'beside.js']);
    await page.page.waitForFunction(() => document.getElementById('scene').value === 'jelly');
  },

  async 'a mesh that is dropped on the page is opened'(page) {
    await page.go('#scene=chain');
    const mesh = await readFile(new URL('../crates/msd-scene/meshes/teapot.obj', import.meta.url), 'utf8');
    await page.page.evaluate(mesh => {
      const dataTransfer = new DataTransfer();
      dataTransfer.items.add(new File([mesh], 'my teapot.obj'));
      document.body.dispatchEvent(new DragEvent('drop', { dataTransfer, bubbles: true, cancelable: true }));
    }, mesh);
    await page.until('the mesh', now => now.scene === 'my teapot');
    await page.picture('dropped');
  },

  async 'a file that is none of ours is refused in a line'(page) {
    await page.go('#scene=chain');
    const wrong = [['nothing.txt', 'unknown extension'], ['broken.obj', 'broken.obj'], ['no.msd', 'no.msd']];
    for (const [name, words] of wrong) {
      await page.page.setInputFiles('#open', { name, mimeType: 'text/plain', buffer: Buffer.from('v 1 nan') });
      await page.page.waitForFunction(
        words => document.getElementById('line').textContent.includes(words), words);
      assert.equal((await page.status()).scene, 'chain');
    }
  },

  async 'a saved run opens again where it was, and a picture is not empty'(page) {
    await page.go('#scene=chain');
    await page.until('steps', now => 5 < now.steps);
    await page.page.click('[data-command=pause]');
    const before = await page.until('a pause', now => now.paused);
    const saved = async button => {
      const [download] = await Promise.all([page.page.waitForEvent('download'), page.page.click(button)]);
      return download.path();
    };
    const file = await saved('#save');
    const picture = await readFile(await saved('#picture'));
    assert(picture.subarray(1, 4).toString() === 'PNG' && 10_000 < picture.length, `${picture.length}`);
    await page.page.click('[data-command=restart]');
    await page.until('a restart', now => now.steps < before.steps);
    await page.page.setInputFiles('#open', { name: 'chain.msd', mimeType: '', buffer: await readFile(file) });
    const after = await page.until('the run', now => now.steps === before.steps);
    assert.equal(after.time, before.time);
  },

  async 'a recording is downloaded, and replays to the same bits on the desktop'(page) {
    await page.go('#scene=chain');
    await page.page.keyboard.press('F9');
    const begun = await page.status();
    await page.until('steps', now => begun.steps + 20 < now.steps);
    const [download] = await Promise.all([page.page.waitForEvent('download'), page.page.keyboard.press('F9')]);
    assert.equal(download.suggestedFilename(), 'chain-1.msdrec');
    const msd = desktop();
    if (!msd) return;
    const copy = join(page.folder, 'chain-1.msdrec');
    await download.saveAs(copy);
    const report = JSON.parse(execFileSync(msd, ['run', '--replay', copy, '--json']));
    assert.equal(report.replay.same_bits, true);
  },

  async 'a recording is kept, and opens where it ended'(page) {
    await page.go('#scene=chain');
    await page.page.keyboard.press('F9');
    const begun = await page.status();
    await page.until('steps', now => begun.steps + 20 < now.steps);
    const kept = await page.page.locator('#recordings option').count();
    await Promise.all([page.page.waitForEvent('download'), page.page.keyboard.press('F9')]);
    // Leaving the page before the recording is stored would lose it.
    await page.page.waitForFunction(
      kept => kept < document.querySelectorAll('#recordings option').length, kept);
    await page.go('#scene=square');
    const newest = page.page.locator('#recordings option').nth(1);
    assert.match(await newest.textContent(), /^chain-1\.msdrec/);
    await page.page.selectOption('#recordings', { index: 1 });
    await page.line('here is its last state');
    const after = await page.status();
    assert.equal(after.scene, 'chain');
    assert(begun.steps + 20 < after.steps, `${after.steps}`);
  },

  async 'embedded, the scene fills the frame'(page) {
    await page.go('#scene=cube&embed');
    const { view } = await page.until('no panels', now => now.view[2] === 960);
    assert.deepEqual(view, [0, 0, 960, 640]);
    await page.picture('embedded');
  },

  async 'controls of the page have names, and choose a scene'(page) {
    await page.go('');
    await page.page.getByRole('combobox', { name: 'Scene' }).selectOption('chain');
    await page.until('another scene', now => now.scene === 'chain');
    await page.page.getByRole('button', { name: 'Pause' }).click();
    await page.until('a pause', now => now.paused);
    await page.page.getByRole('button', { name: 'Resume' }).click();
    await page.until('going on', now => !now.paused);
    const names = await page.page.locator('#bar button').allTextContents();
    assert.equal(new Set(names).size, names.length, `${names}`);
    const picture = await page.page.getAttribute('meta[property="og:image"]', 'content');
    assert.match(picture, /still\.webp$/);
  },
};

// These tests do not depend on the graphics API.
const once = {
  async 'the trade is measured beside the page, with what is wished for and the prices of the parts'(page) {
    await page.page.setViewportSize({ width: 1280, height: 800 });
    await page.go('#scene=chain');
    const { landmarks } = await page.until('steps', now => 2 < now.steps);
    const [left, top, width, height] = landmarks.trade;
    await page.click([left + width / 2, top + height / 2]);
    const first = await page.until('points', now => 3 < (now.trade?.measured ?? 0));
    // The clock must resolve a run.
    assert(0 < first.trade.cheapest && first.trade.cheapest < 1, `${first.trade.cheapest} s/s`);
    const priced = await page.until('prices', now => 0 < (now.trade?.parts ?? 0));
    assert.equal(priced.trade.failure, null);
    await page.picture('trade');
    // Steps continued in the meantime.
    assert(first.steps < priced.steps, `${first.steps} and ${priced.steps} steps`);
    await page.page.evaluate(() => window.msd.msd.command('restart'));
    const done = await page.until('the end of the study', now => now.trade?.done);
    // A change of a field begins a search in another worker.
    const field = done.landmarks.within;
    await page.drag([field[0] + field[2] / 2, field[1] + field[3] / 2], [-12, 0]);
    await page.until('a search', now => /^error below .* tried$/.test(now.trade?.search ?? ''));
    await page.page.evaluate(() => window.msd.open('#scene=square'));
    await page.until('a study of the new scene', now => now.scene === 'square' && 0 < (now.trade?.measured ?? 0));
    await page.page.setViewportSize({ width: 960, height: 640 });
  },

  async 'every scene of the list opens and moves'(page) {
    await page.go('#scene=cube');
    await page.page.evaluate(() => window.msd.msd.set_bare(true));
    const scenes = await page.page.evaluate(
      () => window.msd.msd.scenes().split('\n').map(line => line.split(' ')[0]));
    assert(14 <= scenes.length, `${scenes}`);
    for (const scene of scenes) {
      await page.page.evaluate(scene => window.msd.open(`#scene=${scene}`), scene);
      await page.until(scene, now => now.scene === scene && 2 < now.steps);
      const before = await page.page.screenshot();
      const { steps } = await page.status();
      await page.until(`more of ${scene}`, now => steps + 6 < now.steps);
      assert(!before.equals(await page.page.screenshot()), `${scene} stands still`);
    }
  },

  async 'the kept hashes are those computed in the page'(page) {
    await page.go('#scene=chain&verify');
    await page.page.waitForFunction(() => document.documentElement.dataset.verified, null,
      { timeout: 5 * PATIENCE });
    const line = await page.page.evaluate(() => document.documentElement.dataset.verified);
    assert.match(line, /^all \d+ runs match the reference bits/);
    console.log(`    ${line}`);
  },

  async 'recordings that the first version of the storage kept are still there'(page) {
    await page.go('#scene=chain');
    await page.page.evaluate(() => new Promise((done, failed) => {
      indexedDB.deleteDatabase('msd');
      const request = indexedDB.open('msd', 1);
      request.onerror = failed;
      request.onupgradeneeded = () => {
        const recordings = request.result.createObjectStore('recordings', { autoIncrement: true });
        recordings.add({ name: 'old-1.msdrec', bytes: Uint8Array.of(1, 2, 3), date: Date.UTC(2026, 0, 2) });
      };
      request.onsuccess = () => done(request.result.close());
    }));
    await page.go('#scene=chain');
    const oldest = page.page.locator('#recordings option').last();
    assert.match(await oldest.textContent(), /^old-1\.msdrec, .*2026/);
  },

  async 'a fault of the program is said in words; in a worker it ends nothing else'(page) {
    await page.go('#scene=chain');
    const refusal = await page.page.evaluate(() => window.msd.beside('fail').then(() => '', String));
    assert.match(refusal, /could not do this, by a fault of its own: .*a test has asked for it/s);
    const { steps } = await page.status();
    await page.until('going on', now => steps < now.steps);
    await page.page.evaluate(() => { setTimeout(window.msd.msd.fail); });
    await page.line('stopped by a fault of its own: panicked at');
    assert.match(await page.page.textContent('#line'), /a test has asked for it\nLoad the page again/);
    assert.equal(await page.state(), 'stopped');
    assert(await page.page.evaluate(() => document.getElementById('canvas').inert), 'it takes no input');
    await page.picture('stopped');
    page.said = page.said.filter(line => !/a test has asked for it|unreachable/.test(line));
  },

  async 'it can be installed'(page) {
    await page.go('');
    await page.page.evaluate(() => navigator.serviceWorker.ready);
    const { errors, url } = await page.cdp.send('Page.getAppManifest');
    assert.deepEqual([errors, url], [[], `${page.url}manifest.webmanifest`]);
    const { installabilityErrors } = await page.cdp.send('Page.getInstallabilityErrors');
    assert.deepEqual(installabilityErrors, []);
  },

  async 'it opens again without a network'(page) {
    await page.go('#scene=chain');
    await page.page.evaluate(() => navigator.serviceWorker.ready);
    await page.context.setOffline(true);
    await page.go('#scene=square');
    assert.equal(await page.state(), 'running');
    await page.context.setOffline(false);
  },
};

// The steps on the graphics card, which need WebGPU.
const gpu = {
  async 'the GPU takes the steps, with the bits of the desktop, and says how many are checked'(page) {
    await page.go('#scene=cloth');
    await page.switchGpu();
    await page.until('steps of the GPU', now => 30 < now.gpu?.steps && 0 < now.gpu.checked);
    await page.picture('gpu');
    await page.page.keyboard.press('Space');
    const paused = await page.until('a pause', now => now.paused);
    // This step does not wait for the GPU.
    await page.page.keyboard.press('.');
    const after = await page.until('a step more', now => paused.steps < now.steps);
    // The GPU may have computed it before the pause.
    const taken = ({ gpu }) => gpu.steps + gpu.left;
    assert.equal(taken(after), taken(paused) + 1);
    assert.equal(after.refusal, null);
    assert.equal(await stateHash(page, 'cloth.msd', 0), await stateHash(page, 'cloth', after.steps));
    // Another scene is the processor's until the switch is turned on again.
    await page.page.evaluate(() => window.msd.open('#scene=chain'));
    await page.until('another scene', now => now.scene === 'chain' && now.gpu === null);
    await page.page.keyboard.press('Space');
  },

  async 'what a hand does while the GPU steps has the same bits when it is replayed on the desktop'(page) {
    // An earlier test has turned the camera of this scene.
    await page.forget();
    await page.go('#scene=cloth');
    await page.switchGpu();
    await page.until('steps of the GPU', now => 5 < now.gpu?.steps);
    await page.page.keyboard.press('F9');
    await page.until('a recording', now => now.recording);
    // What moves would be elsewhere when the hand comes.
    await page.page.keyboard.press('Space');
    const paused = await page.until('a pause', now => now.paused);
    assert(paused.aim, JSON.stringify(paused));
    await page.drag(paused.aim.screen, [60, -80], async () => {
      const held = await page.status();
      assert.notEqual(held.held, null, 'something is held');
      await page.page.keyboard.press('Space');
      await page.until('steps with a grab', now => held.steps + 10 < now.steps);
    });
    const free = await page.until('a release', now => now.held === null);
    const { gpu } = await page.until('steps after it', now => free.gpu.steps + 10 < now.gpu.steps);
    assert(paused.steps < free.steps && 0 < gpu.checked, JSON.stringify(gpu));
    const [download] = await Promise.all([page.page.waitForEvent('download'), page.page.keyboard.press('F9')]);
    const msd = desktop();
    if (!msd) return;
    const copy = join(page.folder, 'cloth-1.msdrec');
    await download.saveAs(copy);
    const report = JSON.parse(execFileSync(msd, ['run', '--replay', copy, '--json']));
    assert.equal(report.replay.same_bits, true);
  },

  async 'if the GPU is lost, the run goes on on the processor and says so'(page) {
    await page.go('#scene=jelly');
    await page.switchGpu();
    const { steps } = await page.until('steps of the GPU', now => 10 < now.gpu?.steps);
    await page.page.evaluate(() => window.msd.msd.lose_gpu());
    const lost = await page.until('a loss', now => now.gpu === null);
    assert.match(lost.refusal, /was lost: .*; the run continues on the processor$/);
    await page.picture('gpu-lost');
    await page.until('going on', now => steps + 20 < now.steps);
    await page.page.keyboard.press('Space');
    const paused = await page.until('a pause', now => now.paused);
    assert.equal(await stateHash(page, 'jelly.msd', 0), await stateHash(page, 'jelly', paused.steps));
    await page.page.keyboard.press('Space');
    // A new one can be opened.
    await page.switchGpu();
    await page.until('steps of another', now => 5 < now.gpu?.steps);
    page.said = page.said.filter(line => !/device.*(lost|destroyed)/i.test(line));
  },

  async 'a scene that the GPU does not step stays on the processor, and it says why'(page) {
    await page.go('#scene=chain');
    const file = { name: 'jelly.toml', mimeType: '', buffer: Buffer.from(await automatic('jelly')) };
    await page.page.setInputFiles('#open', file);
    await page.until('the scene', now => now.scene === 'jelly' && 5 < now.steps);
    await page.switchGpu();
    const { steps, gpu } = await page.until('a refusal', now => /does not step automatic/.test(now.refusal ?? ''));
    assert.equal(gpu, null);
    await page.until('going on', now => steps < now.steps);
  },
};

// A page without WebGPU steps on the processor.
const noGpu = {
  async 'without WebGPU the switch of the GPU does nothing'(page) {
    await page.go('#scene=jelly');
    const { steps } = await page.switchGpu();
    const after = await page.until('steps', now => steps + 30 < now.steps);
    assert.deepEqual([after.gpu, after.refusal], [null, null]);
    await page.picture('no-gpu');
  },
};

// Returns the hash of a state after so many frames: of a scene on the desktop, or of the saved run
// of the page.
async function stateHash(page, source, frames) {
  const msd = desktop();
  if (!msd) return null;
  const file = source.endsWith('.msd') ? join(page.folder, source) : source;
  if (file !== source) {
    const [download] = await Promise.all([page.page.waitForEvent('download'), page.page.click('#save')]);
    await download.saveAs(file);
  }
  const run = ['run', file, '--duration', `${frames / 60}`, '--json'];
  return JSON.parse(execFileSync(msd, run)).state_hash;
}

// A phone: a small screen with two or three pixels per CSS pixel.
const phone = {
  async 'the canvas has as many pixels as the screen, and the scene the room'(page) {
    await page.go('#scene=cube');
    const { view } = await page.until('steps', now => 2 < now.steps);
    const canvas = await page.page.evaluate(() => {
      const { width, height, clientWidth, clientHeight } = document.getElementById('canvas');
      return { ratio: devicePixelRatio, width, height, clientWidth, clientHeight };
    });
    const { ratio } = canvas;
    assert.equal(ratio, page.way.startsWith('webgpu') ? 2 : 3);
    assert(Math.abs(canvas.width - ratio * canvas.clientWidth) <= 1, JSON.stringify(canvas));
    assert(Math.abs(canvas.height - ratio * canvas.clientHeight) <= 1, JSON.stringify(canvas));
    assert.equal(view[2], canvas.clientWidth);
    if (page.way.startsWith('webgpu')) await page.photo('browser-phone');
    await page.page.getByRole('button', { name: 'Panels' }).click();
    await page.until('a panel below', now => now.view[3] < 0.7 * view[3]);
    await page.picture(`phone-${ratio}`);
  },

  async 'a finger shows one panel, and the body stays in view'(page) {
    await page.cdp.send('Emulation.setTouchEmulationEnabled', { enabled: true });
    for (const [width, height] of [[390, 844], [844, 390]]) {
      await page.cdp.send('Emulation.setDeviceMetricsOverride',
        { width, height, deviceScaleFactor: 0, mobile: true });
      await page.forget();
      await page.go('#scene=cube');
      const { view } = await page.until('steps', now => 2 < now.steps);
      const bar = await page.page.locator('#bar').boundingBox();
      assert(bar.height <= 60, `the bar is ${bar.height} high`);
      assert.deepEqual([view[2], view[3]], [width, height - bar.height], 'the scene has the room');
      const press = async id => {
        const box = await page.page.locator(id).boundingBox();
        assert(44 <= box.height && 44 <= box.width, `${id} is ${box.width} by ${box.height}`);
        await page.page.locator(id).click();
      };
      await press('#more');
      for (const box of await page.page.locator('#rest > :visible').all()) {
        const { x, y, width: wide, height: high } = await box.boundingBox();
        assert(44 <= high && 0 <= x && x + wide <= width && y + high <= height, `${x} ${y}`);
      }
      await press('#more');
      await press('[data-command=panels]');
      const shown = await page.until('a panel', now => now.view[2] * now.view[3] < 0.9 * view[2] * view[3]);
      assert(0.5 * view[2] * view[3] <= shown.view[2] * shown.view[3], `${shown.view}`);
      await page.frames(30);
      const coloured = await page.coloured(shown.view);
      assert(0.05 < coloured, `${coloured} of the middle has a colour`);
      await page.picture(`phone-${width}x${height}-${page.way.split(' ')[0]}`);
    }
    await page.cdp.send('Emulation.clearDeviceMetricsOverride');
    await page.cdp.send('Emulation.setTouchEmulationEnabled', { enabled: false });
  },
};

// A browser without any graphics API gets a message.
const blind = {
  async 'a page without graphics says what is missing'(page) {
    await page.go('');
    assert.equal(await page.state(), 'missing');
    assert.match(await page.page.textContent('#stage'), /WebGPU or WebGL2/);
  },
};

// Returns whether a test passes, with an empty console if required.
async function passes(page, name, test, quiet) {
  const start = Date.now();
  [page.said, page.asked, page.isLate] = [[], [], false];
  try {
    await page.pass(test);
    if (quiet) page.check();
    console.log(`ok  ${name} (${Date.now() - start} ms)`);
    return true;
  } catch (error) {
    console.log(`BAD ${name}\n${error.stack}\n${page.said.join('\n')}`);
    page.isLate = /^Timeout|: Timeout|it never happens/.test(error.message);
    return false;
  }
}

if (!executable) {
  console.log('web-test: SKIPPED, no Chromium (install it with: apt install chromium)');
  process.exit(process.env.MSD_REQUIRE_BROWSER ? 1 : 0);
}
const { server, url } = await serve();
let failed = 0;
const only = process.env.MSD_WEB_TEST ? new RegExp(process.env.MSD_WEB_TEST) : /./;
const small = (way, ratio) =>
  [...WAYS[way], `--force-device-scale-factor=${ratio}`, '--window-size=500,860'];
for (const [way, flags, list, view] of [
  ['webgpu', WAYS.webgpu, { ...tests, ...once, ...gpu }],
  ['webgl2', WAYS.webgl2, { ...tests, ...noGpu }],
  ['webgpu on a phone', small('webgpu', 2), phone, null],
  ['webgl2 on a phone', small('webgl2', 3), phone, null],
  ['neither', ['--disable-gpu', '--disable-3d-apis'], blind],
]) {
  const open = async () => {
    const page = await Page.open(executable, way, flags, url, view);
    return Object.assign(page, { pictures: process.argv[2] });
  };
  const renewed = page => page.close().then(open);
  let page = await open();
  for (const [name, test] of Object.entries(list)) {
    if (!only.test(`${way}: ${name}`)) continue;
    const attempt = () => passes(page, `${way}: ${name}`, test, list !== blind);
    let passed = await attempt();
    // A browser with software rendering occasionally crashes, hangs or is late. This counts as a
    // failure only if it happens twice.
    if (page.isLost || page.isLate) {
      page = await renewed(page);
      console.log('    once more, in a new browser');
      passed = await attempt();
    }
    failed += passed ? 0 : 1;
    if (page.isLost) page = await renewed(page);
    else if (!passed) await page.picture(`bad-${way}-${failed}`);
  }
  await page.close();
}
server.close();
console.log(failed ? `web-test: ${failed} failed` : 'web-test: all passed');
process.exit(failed ? 1 : 0);
