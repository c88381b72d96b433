// The committed bundle web/dist is what web/src and the lock file give, byte for byte.
import assert from 'node:assert/strict';
import {spawnSync} from 'node:child_process';
import {mkdtempSync, readFileSync, readdirSync, rmSync} from 'node:fs';
import {tmpdir} from 'node:os';
import {dirname, join, resolve} from 'node:path';
import test from 'node:test';
import {fileURLToPath} from 'node:url';

const web = resolve(dirname(fileURLToPath(import.meta.url)), '../../web');

test('building web/ again gives the bytes of web/dist', () => {
  const out = mkdtempSync(join(tmpdir(), 'orasp-web-'));
  try {
    const built = spawnSync(process.execPath, [join(web, 'build.mjs'), '--out', out], {encoding: 'utf8'});
    assert.equal(built.status, 0, built.stderr);
    assert.deepEqual(readdirSync(out).sort(), readdirSync(join(web, 'dist')).sort());
    for (const name of readdirSync(out))
      assert.ok(readFileSync(join(out, name)).equals(readFileSync(join(web, 'dist', name))), `${name} is stale: cd web && npm ci && npm run build`);
  } finally {
    rmSync(out, {recursive: true});
  }
});

test('the lock file names exact versions and the public registry alone', () => {
  const {packages} = JSON.parse(readFileSync(join(web, 'package-lock.json'), 'utf8'));
  const {dependencies, devDependencies} = packages[''];
  for (const [name, version] of Object.entries({...dependencies, ...devDependencies})) assert.match(version, /^\d+\.\d+\.\d+$/, name);
  for (const [name, {resolved, integrity}] of Object.entries(packages)) {
    if (name === '') continue;
    assert.ok(resolved === undefined || resolved.startsWith('https://registry.npmjs.org/'), `${name}: ${resolved}`);
    assert.ok(integrity, name);
  }
});

test('the licences of all bundled libraries stand in the bundles', () => {
  for (const name of ['report.js', 'report-3d.js']) {
    const text = readFileSync(join(web, 'dist', name), 'utf8');
    assert.match(text.slice(0, 200), /Holds these libraries/);
  }
  assert.match(readFileSync(join(web, 'dist/report.js'), 'utf8'), /cytoscape 3[\d.]+ \(MIT\)[\s\S]*Permission is hereby granted/);
  assert.match(readFileSync(join(web, 'dist/report-3d.js'), 'utf8'), /three 0[\d.]+ \(MIT\)[\s\S]*Permission is hereby granted/);
});
