// Compares the speed of steps in Chromium with the same build for any x86-64, alternately, and
// writes the table in docs/measured/performance.md: node web/speed.mjs, after scripts/web.sh.
import { execFileSync } from 'node:child_process';
import { readFile, writeFile } from 'node:fs/promises';
import { Page, WAYS, executable, serve } from './browser.mjs';

const WORKS = ['cloth/31', 'block/20'];
const ROUNDS = 8;
const SECONDS = 0.5;

const root = new URL('..', import.meta.url).pathname;
const xtask = `${root}target/release/xtask`;
const { server, url } = await serve();
const page = await Page.open(executable, 'webgpu', WAYS.webgpu, url);
await page.go('#scene=chain');
await page.page.keyboard.press('Space');
const rows = [];
for (const work of WORKS) {
  const best = { here: 0, page: 0 };
  for (let round = 0; round < ROUNDS; round++) {
    const here = Number(execFileSync(xtask, ['pace', work, String(SECONDS)]));
    const there = await page.page.evaluate(
      ([work, seconds]) => window.msd.msd.measure(work, seconds), [work, SECONDS]);
    best.here = Math.max(best.here, here);
    best.page = Math.max(best.page, there);
  }
  const cells = [best.here / 1e9, best.page / 1e9, best.page / best.here];
  rows.push(`| ${work} | ${cells.map(cell => cell.toFixed(2)).join(' | ')} |`);
  console.log(rows.at(-1));
}
const version = page.context.browser()?.version() ?? '';
await page.close();
server.close();

const path = `${root}docs/measured/performance.md`;
const text = await readFile(path, 'utf8');
const table = '| scene | SSE2, here | simd128, in the page | page / here |\n|---|---|---|---|\n'
  + `${rows.join('\n')}\n\nChromium ${version}, ${new Date().toISOString().slice(0, 10)}.\n`;
const [before, rest] = text.split('<!-- begin browser -->\n');
const [, after] = rest.split('<!-- end browser -->');
await writeFile(path, `${before}<!-- begin browser -->\n${table}<!-- end browser -->${after}`);
