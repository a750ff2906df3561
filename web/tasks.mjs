// Measures how long the page does not respond while each built-in scene is opened and then runs for
// a second, and writes the table in docs/browser.md: node web/tasks.mjs, after scripts/web.sh.
import { readFile, writeFile } from 'node:fs/promises';
import { Page, WAYS, executable, serve } from './browser.mjs';

const root = new URL('..', import.meta.url).pathname;
const { server, url } = await serve();
const page = await Page.open(executable, 'webgpu', WAYS.webgpu, url);
await page.go('#scene=square');
const scenes = await page.page.evaluate(() => window.msd.msd.scenes().split('\n').map(line => line.split(' ')[0]));
// The browser reports tasks of 50 ms and more.
await page.page.evaluate(() => {
  window.tasks = [];
  new PerformanceObserver(list => window.tasks.push(...list.getEntries().map(task => task.duration)))
    .observe({ type: 'longtask' });
});
const longest = () => page.page.evaluate(() => Math.max(0, ...window.tasks.splice(0)));
const rows = [];
for (const scene of scenes) {
  await page.page.waitForTimeout(500);
  await longest();
  await page.page.evaluate(scene => window.msd.msd.open(`#scene=${scene}`), scene);
  await page.until('the scene', now => now.scene === scene);
  await page.page.waitForTimeout(200);
  const opening = await longest();
  await page.page.waitForTimeout(1000);
  const running = await longest();
  const cell = time => (time ? `${Math.round(time)}` : '< 50');
  rows.push(`| ${scene} | ${cell(opening)} | ${cell(running)} |`);
  console.log(rows.at(-1));
}
const version = page.context.browser()?.version() ?? '';
await page.close();
server.close();

const path = `${root}docs/browser.md`;
const [before, rest] = (await readFile(path, 'utf8')).split('<!-- begin tasks -->\n');
const [, after] = rest.split('<!-- end tasks -->');
const table = '| scene | opening, ms | running, ms |\n|---|---|---|\n'
  + `${rows.join('\n')}\n\nChromium ${version}, ${new Date().toISOString().slice(0, 10)}.\n`;
await writeFile(path, `${before}<!-- begin tasks -->\n${table}<!-- end tasks -->${after}`);
