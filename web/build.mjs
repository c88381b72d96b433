// Builds the page of `orasp report`: src/ and the libraries into dist/, which is kept in the repository and compiled into
// the program. The same sources and lock file give the same bytes.
//   npm ci && npm run build             writes dist/
//   node build.mjs --out FOLDER         writes elsewhere, for the test that compares the two
import {createHash} from 'node:crypto';
import {existsSync, mkdirSync, readFileSync, readdirSync, writeFileSync} from 'node:fs';
import {dirname, join} from 'node:path';
import {fileURLToPath} from 'node:url';
import {build} from 'esbuild';

const root = dirname(fileURLToPath(import.meta.url));
const out = process.argv[2] === '--out' ? process.argv[3] : join(root, 'dist');
mkdirSync(out, {recursive: true});

/** The packages that are in a bundle, by esbuild's account of its inputs. */
function packagesOf(metafile) {
  const names = new Set();
  for (const input of Object.keys(metafile.inputs)) {
    const match = /^node_modules\/((?:@[^/]+\/)?[^/]+)\//.exec(input);
    if (match) names.add(match[1]);
  }
  return [...names].sort();
}

/** Name, version and licence text of a package. */
function notice(name) {
  const folder = join(root, 'node_modules', name);
  const {version, license} = JSON.parse(readFileSync(join(folder, 'package.json'), 'utf8'));
  const file = readdirSync(folder).find((entry) => /^licen[cs]e(\.|$)/i.test(entry));
  if (!file) throw new Error(`${name} has no licence file`);
  const text = readFileSync(join(folder, file), 'utf8').replaceAll('\r\n', '\n').trim();
  return `${name} ${version} (${license})\n\n${text}`;
}

async function bundle(entry) {
  const result = await build({
    absWorkingDir: root,
    entryPoints: [`src/${entry}`],
    bundle: true,
    minify: true,
    format: 'iife',
    target: ['es2020'],
    charset: 'ascii',
    legalComments: 'none',  // the licences stand in full in THIRD_PARTY.txt and at the head of the bundle
    metafile: true,
    write: false,
  });
  const code = result.outputFiles[0].text.trim();
  const packages = packagesOf(result.metafile);
  const notices = packages.map(notice).join(`\n\n${'-'.repeat(80)}\n\n`).replaceAll('*/', '* /');
  const text = `/*! Holds these libraries:\n\n${notices}\n*/\n${code}`;
  if (/<\/script|<!--/i.test(text)) throw new Error(`${entry}: the bundle would end the script that holds it`);
  return {text, packages};
}

const policyHash = (text) => `'sha256-${createHash('sha256').update(text).digest('base64')}'`;

const main = await bundle('main.js');
const three = await bundle('three.js');
const style = (await build({absWorkingDir: root, entryPoints: ['src/report.css'], bundle: true, minify: true, write: false, target: ['es2020']}))
  .outputFiles[0].text.trim();
const policy = [
  "default-src 'none'",
  `script-src ${policyHash(main.text)} ${policyHash(three.text)}`,
  "style-src 'unsafe-inline'",
  'img-src data: blob:',
  "base-uri 'none'",
  "form-action 'none'",
].join('; ');
const page = readFileSync(join(root, 'src/report.html'), 'utf8').replace('/*orasp:policy*/', policy);

const files = {
  'report.html': page,
  'report.css': style,
  'report.js': main.text,
  'report-3d.js': three.text,
  'THIRD_PARTY.txt': [...new Set([...main.packages, ...three.packages])].sort().map(notice).join(`\n\n${'='.repeat(80)}\n\n`) + '\n',
};
for (const [name, text] of Object.entries(files)) {
  const file = join(out, name);
  if (!existsSync(file) || readFileSync(file, 'utf8') !== text) writeFileSync(file, text);
  console.log(`${name.padEnd(16)} ${text.length} bytes`);
}
