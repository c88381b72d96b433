// Runs one test file of this folder with what it needs: the packages of web/ from the npm registry, and Chromium.
//   node tests/web/run.mjs FILE PROGRAM FOLDER_FOR_ARTEFACTS
// Exits with 77 (skipped, for ctest) where npm or its registry is out of reach, or for the page's tests there is no Chromium.
import {spawnSync} from 'node:child_process';
import {existsSync, readFileSync, writeFileSync} from 'node:fs';
import {dirname, join, resolve} from 'node:path';
import {fileURLToPath} from 'node:url';

const here = dirname(fileURLToPath(import.meta.url));
const web = resolve(here, '../../web');
const [file, program, artefacts] = process.argv.slice(2);

function skip(why) {
  console.log(`skipped: ${why}`);
  process.exit(77);
}

/** Installs what the lock file says, unless it was done before. */
function install() {
  const lock = readFileSync(join(web, 'package-lock.json'), 'utf8');
  const mark = join(web, 'node_modules/.installed-lock');
  if (existsSync(mark) && readFileSync(mark, 'utf8') === lock) return;
  const done = spawnSync('npm', ['ci', '--no-audit', '--no-fund', '--loglevel=error'], {cwd: web, encoding: 'utf8', timeout: 240_000});
  if (done.error) skip(`npm cannot be run: ${done.error.message}`);
  if (done.status !== 0) skip(`npm ci failed, so the registry may be out of reach: ${done.stderr.trim().split('\n')[0]}`);
  writeFileSync(mark, lock);
}

install();
const chromium = process.env.ORASP_CHROMIUM ?? '/usr/bin/chromium';
if (file !== 'bundle_test.mjs' && !existsSync(chromium)) skip(`there is no ${chromium}`);
const done = spawnSync(process.execPath, ['--test', join(here, file)], {
  stdio: 'inherit',
  env: {...process.env, ORASP_PROGRAM: program, ORASP_ARTEFACTS: artefacts, ORASP_CHROMIUM: chromium},
});
process.exit(done.status ?? 1);
