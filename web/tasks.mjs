// Measures how long the page does not respond while it opens each built-in scene and runs it for 3
// s, and prints a row for each: node web/tasks.mjs, after scripts/web.sh.
//
// The unit is CPU time, which other programs do not affect: the browser traces the tasks of the
// page's thread.
import { Page, WAYS, automatic, executable, serve } from './browser.mjs';

const CATEGORIES = ['toplevel', 'disabled-by-default-devtools.timeline', 'devtools.timeline'];

// Returns the longest task of the page during an action, ms.
async function longest(page, act) {
  const events = [];
  const collect = ({ value }) => events.push(...value);
  page.cdp.on('Tracing.dataCollected', collect);
  await page.cdp.send('Tracing.start', {
    traceConfig: { includedCategories: CATEGORIES }, transferMode: 'ReportEvents',
  });
  await act();
  const complete = new Promise(done => page.cdp.once('Tracing.tracingComplete', done));
  await page.cdp.send('Tracing.end');
  await complete;
  page.cdp.off('Tracing.dataCollected', collect);
  // Chromium has internal pages, in other processes.
  const { frameTree: { frame: { id } } } = await page.cdp.send('Page.getFrameTree');
  const ours = new Set(events.filter(({ args }) => args.data?.frame === id).map(({ pid }) => pid));
  const main = events.filter(({ name, args }) => name === 'thread_name' && args.name === 'CrRendererMain');
  const isMain = ({ pid, tid }) =>
    ours.has(pid) && main.some(thread => thread.pid === pid && thread.tid === tid);
  const tasks = events.filter(event => event.name.endsWith('RunTask') && isMain(event));
  return Math.max(...tasks.map(({ tdur }) => (tdur ?? 0) / 1000));
}

const { server, url } = await serve();
const page = await Page.open(executable, 'webgpu', WAYS.webgpu, url);
const loading = await longest(page, () => page.go('#scene=cube'));
console.log(`the page itself: ${loading.toFixed(0)} ms`);
const scenes = await page.page.evaluate(() => window.msd.msd.scenes().split('\n').map(line => line.split(' ')[0]));
console.log('| scene | opening, ms | running, ms |');
for (const scene of scenes) {
  // Another scene first: reopening the same name would not load it.
  await page.page.evaluate(other => window.msd.open(`#scene=${other}`), scene === 'square' ? 'chain' : 'square');
  await page.page.waitForTimeout(1000);
  const opening = await longest(page, async () => {
    await page.page.evaluate(scene => window.msd.open(`#scene=${scene}`), scene);
    await page.until('the scene', now => now.scene === scene);
    await page.frames(2);
  });
  const running = await longest(page, () => page.page.waitForTimeout(3000));
  console.log(`| ${scene} | ${opening.toFixed(0)} | ${running.toFixed(0)} |`);
}
// A prediction chooses automatic substeps at the start and after a change.
for (const scene of ['bunny', 'foam']) {
  await page.page.evaluate(() => window.msd.open('#scene=chain'));
  await page.page.waitForTimeout(1000);
  const file = { name: `${scene}.toml`, mimeType: '', buffer: Buffer.from(await automatic(scene)) };
  const opening = await longest(page, async () => {
    await page.page.setInputFiles('#open', file);
    await page.until('the scene', now => now.scene === scene && 0 < now.steps);
    await page.frames(2);
  });
  const { landmarks: { stiffness: [left, top, , height] } } = await page.status();
  const running = await longest(page, async () => {
    await page.drag([left + 40, top + height / 2], [6, 0]);
    await page.page.waitForTimeout(3000);
  });
  console.log(`| ${scene}, automatic, made stiffer | ${opening.toFixed(0)} | ${running.toFixed(0)} |`);
}
// The card is checked before its first step, and a step now and then.
await page.page.evaluate(() => window.msd.open('#scene=cloth'));
await page.page.waitForTimeout(1000);
const opening = await longest(page, async () => {
  await page.switchGpu();
  await page.until('steps of the GPU', now => 0 < now.gpu?.steps);
});
const running = await longest(page, () => page.page.waitForTimeout(3000));
console.log(`| cloth, with the GPU | ${opening.toFixed(0)} | ${running.toFixed(0)} |`);
await page.close();
server.close();
