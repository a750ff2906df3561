// Loads the program, and passes messages between it and the controls of the page.
import init, * as msd from './msd.js';
import * as store from './store.js';

const element = id => document.getElementById(id);
const options = () => new Set(location.hash.slice(1).split('&'));

// A module with one function that uses a 128-bit register.
const SIMD = Uint8Array.of(0, 97, 115, 109, 1, 0, 0, 0, 1, 5, 1, 96, 0, 1, 123, 3, 2, 1, 0, 10, 10, 1,
  8, 0, 65, 0, 253, 15, 253, 98, 11);

const MISSING = 'msd cannot run in this browser. It draws with WebGPU or WebGL2 and computes with '
  + 'WebAssembly SIMD, which Chrome and Edge have since version 91, Firefox since 89 and Safari '
  + 'since 16.4. The programs for the desktop need no browser.';

// Shows what is missing, above the still image, if there is no window.
function missing(reason) {
  document.documentElement.dataset.state = 'missing';
  element('stage').textContent = reason ? `${MISSING}\n(${reason})` : MISSING;
  element('progress').hidden = true;
  element('loading').hidden = false;
}

let hiding;
let fault;
function say(text) {
  const line = element('line');
  line.textContent = fault ?? text;
  line.hidden = false;
  clearTimeout(hiding);
  if (!fault) hiding = setTimeout(() => { line.hidden = true; }, 15000);
}

// Stops input after a fault of the program, whose state may be inconsistent.
function stop(error) {
  // Browsers report some harmless problems without an error. Later errors say less than the first.
  if (!error || fault) return;
  fault = `msd has stopped by a fault of its own: ${error.message ?? error}\n`
    + 'Load the page again to go on. It helps to report these lines.';
  say(fault);
  document.documentElement.dataset.state = 'stopped';
  for (const part of ['bar', 'canvas']) element(part).inert = true;
}
addEventListener('error', event => stop(event.error));
addEventListener('unhandledrejection', event => stop(event.reason));

let wantsPicture = false;

const told = {
  frame() {
    if (!['running', 'stopped'].includes(document.documentElement.dataset.state)) {
      element('loading').hidden = true;
      document.documentElement.dataset.state = 'running';
      document.documentElement.dataset.first = performance.now();
    }
    if (wantsPicture) {
      wantsPicture = false;
      // Synchronously: after this frame the canvas is cleared.
      element('canvas').toBlob(blob => download(blob, 'msd.png'));
    }
  },
  scene(name) {
    element('scene').value = name;
    // The scene of a file is not in the list.
    if (element('scene').value !== name) element('scene').value = '';
  },
  paused: text => { element('pause').textContent = text ? 'Resume' : 'Pause'; },
  open: fragment => open(fragment).catch(refused),
  copy: text => copy(text),
  file(name, bytes) {
    download(new Blob([bytes]), name);
    if (name.endsWith('.msdrec')) store.keepRecording(name, bytes).then(listRecordings).catch(() => {});
  },
  preferences: text => store.keepPreferences(text),
  line: text => say(text),
  refused: text => say(text),
  missing: text => missing(text),
};

// Copies a text; a fragment becomes the whole link.
async function copy(text) {
  const link = text.startsWith('#') ? new URL(text, location.href).href : text;
  try {
    await navigator.clipboard.writeText(link);
    say(`Copied: ${link}`);
  } catch {
    // Not allowed here, as in a frame of another page: the user can copy it manually.
    say(link);
  }
}

function download(content, name) {
  const link = document.createElement('a');
  link.href = URL.createObjectURL(content);
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 60000);
}

// A scene and its arrays take a multiple of its file.
const LARGEST = 200e6;

async function openFile(file) {
  if (LARGEST < file.size) {
    return say(`${file.name}: too large for a browser, ${Math.round(file.size / 1e6)} MB of at most `
      + `${LARGEST / 1e6} MB; the program for the desktop takes it`);
  }
  await openBytes(file.name, new Uint8Array(await file.arrayBuffer()));
}

// Opens the bytes of a file, or the last state of a recording.
async function openBytes(name, bytes) {
  if (!name.endsWith('.msdrec')) {
    const turn = ++asked;
    const rows = await beside('opened_file', name, bytes);
    return turn === asked ? msd.show_file(name, bytes, rows) : undefined;
  }
  say(`Replaying ${name}`);
  const run = await beside('replayed', name, bytes);
  await openBytes(name.replace(/rec$/, ''), run);
  say(`${name}: here is its last state`);
}

// Number of the last request for a scene.
let asked = 0;

// Opens the scene of a fragment.
async function open(fragment) {
  const turn = ++asked;
  const rows = await beside('opened', fragment);
  if (turn === asked) await msd.show_link(fragment, rows);
}

// The compiled program, for workers.
let module;

// Returns the result of a function of the program, which runs in a worker.
function beside(name, ...what) {
  const worker = new Worker('beside.js', { type: 'module' });
  const ended = new Promise((done, failed) => {
    worker.onmessage = ({ data }) => (data.error ? failed(data.error) : done(data.result));
    // A fault of the program ends only the worker.
    worker.onerror = event => {
      event.preventDefault();
      failed(`msd could not do this, by a fault of its own: ${event.message}`);
    };
  });
  worker.postMessage({ module, name, what });
  return ended.finally(() => worker.terminate());
}

async function listRecordings() {
  const kept = await store.recordings();
  const choice = element('recordings');
  const option = ([date, name]) =>
    new Option(`${name}, ${new Date(date).toLocaleString()}`, JSON.stringify([date, name]));
  choice.replaceChildren(new Option('Choose', ''), ...kept.map(option));
  element('recorded').hidden = kept.length === 0;
}

async function openRecording() {
  const chosen = element('recordings').value;
  element('recordings').value = '';
  if (!chosen) return;
  const key = JSON.parse(chosen);
  await openBytes(key[1], await store.recording(key));
}

// Lets the page respond before the next task.
const rest = () => new Promise(next => { setTimeout(next); });

// Loads the program, with a progress bar.
async function program() {
  const response = await fetch('msd_bg.wasm');
  if (!response.ok) throw new Error(`the program is not there: ${response.status}`);
  const size = Number(document.querySelector('meta[name=size]').content);
  let done = 0;
  const count = new TransformStream({
    transform(part, out) {
      done += part.length;
      element('progress').value = Math.min(1, done / size);
      out.enqueue(part);
    },
  });
  // Independent of the server's content type.
  const headers = { 'content-type': 'application/wasm' };
  return WebAssembly.compileStreaming(new Response(response.body.pipeThrough(count), { headers }));
}

function listScenes() {
  const choice = element('scene');
  for (const line of msd.scenes().split('\n')) {
    const [name, ...title] = line.split(' ');
    const option = new Option(`${name}: ${title.join(' ')}`, name);
    choice.add(option);
  }
}

// Stored preferences; by default the scene fills a small screen.
const isSmall = () => matchMedia('(max-width: 699px), (max-height: 479px)').matches;
const remembered = () => store.preferences() ?? (isSmall() ? '{"panels": false}' : undefined);

const refused = error => say(String(error));

function connect() {
  for (const button of document.querySelectorAll('[data-command]')) {
    button.addEventListener('click', () => msd.command(button.dataset.command).catch(refused));
  }
  element('scene').addEventListener('change', () => {
    const fragment = `#scene=${element('scene').value}`;
    if (!element('scene').value) return;
    history.replaceState(null, '', fragment);
    open(fragment).catch(refused);
  });
  const more = element('more');
  const unfold = open => more.setAttribute('aria-expanded', open);
  more.addEventListener('click', () => unfold(more.ariaExpanded !== 'true'));
  // A choice in the menu, or a press elsewhere, closes it.
  element('rest').addEventListener('click', () => unfold(false));
  element('canvas').addEventListener('pointerdown', () => unfold(false));
  element('copy').addEventListener('click', () => msd.link().then(copy, refused));
  element('verify').addEventListener('click', verify);
  element('save').addEventListener('click', () => msd.saved().then(bytes => {
    download(new Blob([bytes]), `${element('scene').value || 'scene'}.msd`);
  }, refused));
  element('picture').addEventListener('click', () => {
    wantsPicture = true;
    // The result is not used, but the request causes a frame.
    msd.status();
  });
  element('open').addEventListener('change', () => {
    const [file] = element('open').files;
    if (file) openFile(file).catch(refused);
    element('open').value = '';
  });
  element('recordings').addEventListener('change', () => openRecording().catch(refused));
  // For WebGL2 only: a WebGPU device reports its loss itself.
  element('canvas').addEventListener('webglcontextlost', event => {
    event.preventDefault();
    msd.graphics_lost();
  });
  element('canvas').addEventListener('webglcontextrestored', () => msd.graphics_restored());
  addEventListener('dragover', event => event.preventDefault());
  addEventListener('drop', event => {
    event.preventDefault();
    const [file] = event.dataTransfer.files;
    if (file) openFile(file).catch(refused);
  });
  addEventListener('hashchange', () => {
    msd.set_bare(setOptions());
    if (location.hash.startsWith('#scene=')) open(location.hash).catch(refused);
    if (options().has('verify')) verify();
  });
  // After a click the simulation gets the focus back.
  element('bar').addEventListener('pointerup', event => {
    if (event.target.tagName === 'BUTTON') setTimeout(() => element('canvas').focus());
  });
}

function setOptions() {
  const embedded = options().has('embed');
  document.documentElement.classList.toggle('embed', embedded);
  return embedded;
}

// Returns the scene of the address or, if it cannot be opened, the first one.
async function first() {
  const fragment = location.hash;
  try {
    return [fragment, await beside('opened_first', fragment)];
  } catch (error) {
    const rows = await beside('opened_first', '');
    say(`${error}; here is ${element('scene').options[0].value} instead`);
    return ['', rows];
  }
}

let verifying = false;
// Computes the hashes of the reference runs in a worker, while the page continues.
function verify() {
  if (verifying) return;
  verifying = true;
  const worker = new Worker('verify.js', { type: 'module' });
  const end = line => {
    element('verify').textContent = 'Verify';
    document.documentElement.dataset.verified = line;
    say(line);
    verifying = false;
    worker.terminate();
  };
  worker.onmessage = ({ data: { line, is_done } }) => {
    element('verify').textContent = line;
    if (is_done) end(line);
  };
  worker.onerror = error => end(`not verified: ${error.message}`);
}

// Interface for tests.
window.msd = { status: async () => JSON.parse(await msd.status()), open, beside, msd };

setOptions();
if ('serviceWorker' in navigator) navigator.serviceWorker.register('sw.js').catch(() => {});
try {
  if (!WebAssembly.validate(SIMD)) throw new Error('WebAssembly SIMD is missing');
  module = await program();
  // In a worker, in the meantime; `await opening` below handles a failure.
  const opening = first();
  opening.catch(() => {});
  await rest();
  await init({ module_or_path: module });
  await rest();
  element('stage').textContent = 'Opening the scene';
  listScenes();
  connect();
  listRecordings().catch(() => {});
  const [fragment, rows] = await opening;
  await rest();
  const byTouch = matchMedia('(pointer: coarse)').matches;
  msd.start(fragment, rows, remembered(), byTouch, (kind, ...what) => told[kind]?.(...what));
  msd.set_bare(setOptions());
  if (options().has('verify')) verify();
} catch (error) {
  missing(error.message ?? String(error));
  console.error(error);
}
