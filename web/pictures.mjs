// Takes the pictures of reports that stand in the documentation, anew, into docs/images/.
//   cd web && npm ci && node pictures.mjs ../build/release/orasp [NAME...]
import {spawnSync} from 'node:child_process';
import {mkdtempSync, rmSync, writeFileSync} from 'node:fs';
import {tmpdir} from 'node:os';
import {dirname, join, resolve} from 'node:path';
import {fileURLToPath} from 'node:url';
import {chromium} from 'playwright-core';
import {boxProblem, cabinet, cabinetFile} from '../tests/web/products.mjs';

const root = resolve(dirname(fileURLToPath(import.meta.url)), '..');
const program = resolve(process.argv[2] ?? join(root, 'build/release/orasp'));
const folder = mkdtempSync(join(tmpdir(), 'orasp-pictures-'));
// A cabinet that the tests of the page take apart too, made for them.
const made = join(folder, 'cabinet.json');
writeFileSync(join(folder, 'cabinet.glb'), cabinetFile());
writeFileSync(made, JSON.stringify(boxProblem(cabinet, {action: 'part', objective: {type: 'completion'}, direction: 'assembly'})));
const pictures = [
  {name: 'report', problem: 'examples/shelf.json', step: 4, height: 860},
  {name: 'report-iss', problem: 'iss-upc', step: 14, element: '#plan', height: 1100},
  {name: 'report-states', problem: '2x3', step: 4, element: '#states', width: 700, height: 1400, type: 'jpeg'},
  {name: 'report-fleet', problem: 'fleet-lattice', step: 2, element: '#lanes', height: 1400},
  {name: 'report-apart', problem: made, step: 0, element: '.stage', height: 1000, apart: 1},
  {name: 'report-book', problem: made, step: 0, element: '.leaf:nth-child(9)', width: 900, height: 1100, book: true},
];

const browser = await chromium.launch({
  executablePath: process.env.ORASP_CHROMIUM ?? '/usr/bin/chromium',
  args: ['--no-sandbox', '--disable-gpu', '--disable-quic', '--no-first-run', '--disable-background-networking', '--disable-component-update', '--disable-sync',
    '--use-angle=swiftshader', '--enable-unsafe-swiftshader'],
});
for (const {name, problem, step, width, height, element, type, apart, book} of pictures.filter(({name}) => process.argv.length < 4 || process.argv.includes(name))) {
  const file = join(folder, `${name}.html`);
  const done = spawnSync(program, ['report', problem, '-o', file], {cwd: root, encoding: 'utf8'});
  if (done.status !== 0) throw new Error(done.stderr);
  const page = await browser.newPage({viewport: {width: width ?? 1180, height: height ?? 900}, reducedMotion: 'reduce'});
  await page.goto(`file://${file}`);
  await page.waitForSelector('html[data-ready]');
  await page.evaluate((place) => globalThis.orasp.position.set(place), step);
  const path = join(root, 'docs/images', `${name}.${type === 'jpeg' ? 'jpg' : 'png'}`);
  const format = type === 'jpeg' ? {type, quality: 80} : {};
  if (apart) {
    await page.locator('.apart').evaluate((slider, share) => {
      slider.value = String(1000 * share);
      slider.dispatchEvent(new Event('input'));
    }, apart);
  }
  if (book) {
    await page.getByRole('button', {name: 'Book'}).click();
    await page.waitForSelector('.book[data-ready]');
    await page.addStyleTag({content: '.book-bar {display: none !important}'});
  }
  if (element) await page.locator(element).first().scrollIntoViewIfNeeded();
  await page.waitForTimeout(1000);
  if (element) await page.locator(element).first().screenshot({path, ...format});
  else await page.screenshot({path, ...format});
  await page.close();
  console.log(path);
}
await browser.close();
rmSync(folder, {recursive: true});
