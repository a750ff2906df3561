// Computes the hashes of the reference runs in a worker, while the page continues.
import init, { Verifier } from './msd.js';

await init({ module_or_path: 'msd_bg.wasm' });
const verifier = new Verifier();
while (!verifier.is_done) {
  const line = verifier.slice(100);
  postMessage({ line, is_done: verifier.is_done });
}
