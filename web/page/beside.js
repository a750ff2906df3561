// Calls one function of the program beside the page, which goes on meanwhile.
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
