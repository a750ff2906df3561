// Measures beside the page, piece by piece: between two pieces it hears what the page wants, and
// rests for as long as the last one took.
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
