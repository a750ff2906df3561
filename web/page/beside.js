// Calls one function of the program in a worker, while the page continues.
import { initSync } from './msd.js';
import * as msd from './msd.js';

onmessage = ({ data: { module, name, what } }) => {
  try {
    initSync({ module });
    postMessage({ result: msd[name](...what) });
  } catch (error) {
    postMessage({ error: String(error) });
  }
};
