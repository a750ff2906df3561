// Measures the time until a first visitor sees motion, with either graphics API, and prints a row
// for each: node web/start.mjs, after scripts/web.sh. The server is local.
import { Page, WAYS, executable, serve } from './browser.mjs';

const VISITS = 5;

const { server, url } = await serve();
console.log('| drawn by | program loaded, s | first picture, s | first motion, s |');
for (const way of Object.keys(WAYS)) {
  const visits = [];
  for (let visit = 0; visit < VISITS; visit++) visits.push(await times(way));
  const median = visits[0].map((_, column) => visits.map(row => row[column]).sort((a, b) => a - b)[VISITS >> 1]);
  const name = { webgpu: 'WebGPU', webgl2: 'WebGL2' }[way];
  console.log(`| ${name} | ${median.map(time => (time / 1000).toFixed(2)).join(' | ')} |`);
}
server.close();

// Measures a visit with a fresh browser: milliseconds until the program is loaded, the first frame,
// and the first frame after a step.
async function times(way) {
  const page = await Page.open(executable, way, WAYS[way], url);
  await page.page.addInitScript(() => {
    const look = async () => {
      if (document.documentElement?.dataset.first && 0 < (await window.msd.status()).steps) {
        requestAnimationFrame(() => { window.moved = performance.now(); });
      } else {
        requestAnimationFrame(look);
      }
    };
    look();
  });
  await page.go('#scene=cube');
  await page.page.waitForFunction(() => window.moved);
  const seen = await page.page.evaluate(() => {
    const program = performance.getEntriesByType('resource').find(({ name }) => name.endsWith('.wasm'));
    return [program.responseEnd, Number(document.documentElement.dataset.first), window.moved];
  });
  await page.close();
  return seen;
}
