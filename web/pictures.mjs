// Takes the pictures of reports that stand in the documentation, anew, into docs/images/.
//   cd web && npm ci && node pictures.mjs ../build/release/orasp
import {spawnSync} from 'node:child_process';
import {mkdtempSync, rmSync} from 'node:fs';
import {tmpdir} from 'node:os';
import {dirname, join, resolve} from 'node:path';
import {fileURLToPath} from 'node:url';
import {chromium} from 'playwright-core';

const root = resolve(dirname(fileURLToPath(import.meta.url)), '..');
const program = resolve(process.argv[2] ?? join(root, 'build/release/orasp'));
const folder = mkdtempSync(join(tmpdir(), 'orasp-pictures-'));
const pictures = [
  {name: 'report', problem: 'examples/shelf.json', step: 4, height: 860},
  {name: 'report-iss', problem: 'iss-upc', step: 14, element: '#plan', height: 1100},
  {name: 'report-states', problem: '2x3', step: 4, element: '#states', width: 700, height: 1400, type: 'jpeg'},
  {name: 'report-fleet', problem: 'fleet-lattice', step: 2, element: '#lanes', height: 1400},
];

const browser = await chromium.launch({
  executablePath: process.env.ORASP_CHROMIUM ?? '/usr/bin/chromium',
  args: ['--no-sandbox', '--disable-gpu', '--disable-quic', '--no-first-run', '--disable-background-networking', '--disable-component-update', '--disable-sync',
    '--use-angle=swiftshader', '--enable-unsafe-swiftshader'],
});
for (const {name, problem, step, width, height, element, type} of pictures) {
  const file = join(folder, `${name}.html`);
  const done = spawnSync(program, ['report', problem, '-o', file], {cwd: root, encoding: 'utf8'});
  if (done.status !== 0) throw new Error(done.stderr);
  const page = await browser.newPage({viewport: {width: width ?? 1180, height: height ?? 900}, reducedMotion: 'reduce'});
  await page.goto(`file://${file}`);
  await page.waitForSelector('html[data-ready]');
  await page.evaluate((place) => globalThis.orasp.position.set(place), step);
  const path = join(root, 'docs/images', `${name}.${type === 'jpeg' ? 'jpg' : 'png'}`);
  const format = type === 'jpeg' ? {type, quality: 80} : {};
  if (element) await page.locator(element).scrollIntoViewIfNeeded();
  await page.waitForTimeout(1000);
  if (element) await page.locator(element).screenshot({path, ...format});
  else await page.screenshot({path, ...format});
  await page.close();
  console.log(path);
}
await browser.close();
rmSync(folder, {recursive: true});
