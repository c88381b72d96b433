// What the tests of the page share: the program, a folder, and a real Chromium in which reports are opened from files.
import assert from 'node:assert/strict';
import {spawnSync} from 'node:child_process';
import {mkdirSync, mkdtempSync, readFileSync, rmSync, statSync, writeFileSync} from 'node:fs';
import {createRequire} from 'node:module';
import {tmpdir} from 'node:os';
import {dirname, join, resolve} from 'node:path';
import {fileURLToPath} from 'node:url';

export const root = resolve(dirname(fileURLToPath(import.meta.url)), '../..');
const require = createRequire(join(root, 'web/package.json'));
const {chromium} = require('playwright-core');
export const axeSource = readFileSync(require.resolve('axe-core/axe.min.js'), 'utf8');

const program = process.env.ORASP_PROGRAM ?? join(root, 'build/release/orasp');
export const artefacts = process.env.ORASP_ARTEFACTS ?? join(root, 'build/web-artefacts');
export const shared = process.env.ORASP_SHARED ?? join(root, '../shared');
const folder = mkdtempSync(join(tmpdir(), 'orasp-page-'));
mkdirSync(artefacts, {recursive: true});

export function orasp(...words) {
  const done = spawnSync(program, words, {encoding: 'utf8', maxBuffer: 64 << 20});
  return {code: done.status, out: done.stdout, err: done.stderr};
}

/** A file in the tests' folder. */
export function file(name, text) {
  const path = join(folder, name);
  if (text !== undefined) writeFileSync(path, text);
  return path;
}

let count = 0;
/** Writes a report; returns its file, the exit code and the seconds that the whole process took. */
export function report(...words) {
  const path = file(`report-${++count}.html`);
  const begin = process.hrtime.bigint();
  const {code, err} = orasp('report', ...words, '-o', path);
  const seconds = Number(process.hrtime.bigint() - begin) / 1e9;
  assert.ok([0, 10, 20].includes(code), err);
  return {path, code, seconds, bytes: statSync(path).size};
}

let browser;
export async function start() {
  browser = await chromium.launch({
    executablePath: process.env.ORASP_CHROMIUM ?? '/usr/bin/chromium',
    args: ['--no-sandbox', '--disable-gpu', '--disable-quic', '--no-first-run', '--disable-background-networking', '--disable-component-update', '--disable-sync',
      '--use-angle=swiftshader', '--enable-unsafe-swiftshader'],
  });
}
export async function stop() {
  await browser.close();
  rmSync(folder, {recursive: true});
}

/** Opens a page and notes what must not happen: errors on the console, requests, dialogs. */
export async function open(path, options = {}) {
  const page = await browser.newPage({viewport: {width: 1280, height: 900}, ...options});
  page.faults = [];
  page.on('console', (message) => {
    if (message.type() === 'error') page.faults.push(`console: ${message.text()}`);
  });
  page.on('pageerror', (error) => page.faults.push(`error: ${error.message}`));
  page.on('dialog', (dialog) => {
    page.faults.push(`dialog: ${dialog.message()}`);
    dialog.dismiss();
  });
  page.on('request', (request) => {
    const url = request.url();
    if (url !== `file://${path}` && !url.startsWith('data:') && !url.startsWith('blob:')) page.faults.push(`request: ${url}`);
  });
  await page.goto(`file://${path}`);
  await page.waitForSelector('html[data-ready]');
  return page;
}

export async function close(page) {
  const {faults} = page;
  await page.close();
  assert.deepEqual(faults, []);
}

export const shot = (page, name, options = {}) => page.screenshot({path: join(artefacts, `${name}.png`), ...options});

export const setSlider = (page, place) => page.locator('#place').evaluate((slider, value) => {
  slider.value = String(value);
  slider.dispatchEvent(new Event('input', {bubbles: true}));
}, place);
