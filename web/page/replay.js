// Replays a recording beside the page, which goes on meanwhile.
import init, { replayed } from './msd.js';

onmessage = async ({ data: { name, bytes } }) => {
  try {
    await init({ module_or_path: 'msd_bg.wasm' });
    postMessage({ run: replayed(name, bytes) });
  } catch (error) {
    postMessage({ error: String(error) });
  }
};
