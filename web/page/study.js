// Runs a study in a worker, piece by piece. Between two pieces it reads messages of the page, and
// pauses for the duration of the last piece.
import { initSync, BackgroundWork } from './msd.js';

let work;
let next;

function advance() {
  next = undefined;
  const start = performance.now();
  if (work.advance()) next = setTimeout(advance, performance.now() - start);
}

onmessage = ({ data }) => {
  if (work) {
    work.hear(data);
  } else {
    const [module, kind, task] = data;
    initSync({ module });
    work = new BackgroundWork(kind, task, note => postMessage(note));
  }
  next ??= setTimeout(advance);
};
