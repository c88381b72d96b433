// The page of `orasp report` in a real Chromium, opened from a file. Screenshots go to ORASP_ARTEFACTS.
import assert from 'node:assert/strict';
import {existsSync, readFileSync} from 'node:fs';
import {join} from 'node:path';
import test, {after, before, describe} from 'node:test';
import {artefacts, axeSource, close, file, open, orasp, report, root, setSlider, shared, shot, start, stop} from './browser.mjs';

before(start);
after(stop);

const scenarios = ['3piece', '4brick', '4piece', '2x3', 'lattice', 'hubble', 'hubble-free', 'hubble-upc', 'iss', 'iss-upc', 'jwst', 'jwst-upc'];
const lego = ['lego-007', 'lego-019', 'lego-031', 'lego-053', 'lego-099'].map((name) => join(shared, 'problems/lego', `${name}.json`)).filter(existsSync);
const shelf = join(root, 'examples/shelf.json');
const shelfWrong = join(root, 'examples/shelf-wrong-order.txt');

/** The pieces after each step of a plan, worked out anew from the problem and the plan file: sorted lists of part ids. */
function piecesOf(problem, order) {
  const ids = problem.connections.map(({id, parts}) => id ?? parts.join('-'));
  const state = (present) => {
    const parent = new Map(problem.parts.map(({id}) => [id, id]));
    const find = (part) => (parent.get(part) === part ? part : find(parent.get(part)));
    problem.connections.forEach(({parts}, c) => {
      if (present.has(ids[c])) parent.set(find(parts[0]), find(parts[1]));
    });
    const pieces = new Map();
    for (const {id} of problem.parts) pieces.set(find(id), [...(pieces.get(find(id)) ?? []), id]);
    return [...pieces.values()].map((parts) => parts.sort().join(' ')).sort();
  };
  const present = new Set(ids);
  const states = [state(present)];
  for (const id of order) {
    present.delete(id);
    states.push(state(present));
  }
  return states;
}

/** What the page shows: its pieces, as piecesOf() writes them, and connections drawn as present. */
const shown = (page, plan = 0) => page.evaluate((at) => {
  const {views, data} = globalThis.orasp;
  const {replay, graph} = views[at];
  const name = (part) => data.problem.parts[part][0];
  return {
    pieces: replay.pieces().map(({parts}) => parts.map(name).sort().join(' ')).sort(),
    drawn: graph.edges.filter((edge) => !edge.hasClass('gone')).length,
    single: graph.nodes.filter((node) => node.hasClass('single')).length,
    written: Number(document.querySelectorAll('.pieces')[at].dataset.pieces),
    title: document.querySelectorAll('.step-title')[at].textContent,
  };
}, plan);

describe('The page', () => {
  test('opens from a file without an error or a request, for every scenario and five LEGO models, in at most 2 MB', async () => {
    const rows = [];
    for (const name of [...scenarios, ...lego]) {
      const {path, bytes, seconds} = report(name);
      assert.ok(bytes <= 2 << 20, `${name}: ${bytes} bytes`);
      const page = await open(path);
      assert.equal(await page.locator('h1').count(), 1);
      rows.push(`| ${name.split('/').pop().replace('.json', '')} | ${Math.round(bytes / 1000)} | ${seconds.toFixed(2)} |`);
      await close(page);
    }
    console.log(`| problem | kB | s |\n|---|---|---|\n${rows.join('\n')}`);
  });

  for (const [name, problem] of [['lattice', 'lattice'], ['shelf, in space', shelf]]) {
    test(`shows the plan's own state at every place of the slider, in both directions: ${name}`, async () => {
      const parsed = JSON.parse(problem === 'lattice' ? orasp('scenarios', 'lattice').out : readFileSync(problem, 'utf8'));
      const plan = JSON.parse(orasp('solve', problem, '--json').out);
      const states = piecesOf(parsed, plan.disassembly);
      const n = plan.disassembly.length;
      const page = await open(report(problem, file('plan.json', JSON.stringify(plan))).path);
      if (problem === shelf) await page.getByRole('button', {name: 'Graph', exact: true}).click();
      assert.equal(await page.locator('#place').getAttribute('max'), String(n));
      for (let place = 0; place <= n; ++place) {
        await setSlider(page, place);
        const {pieces, drawn, single, written, title} = await shown(page);
        assert.deepEqual(pieces, states[place]);
        assert.equal(written, states[place].length);
        assert.equal(drawn, n - place);
        assert.equal(single, states[place].filter((piece) => !piece.includes(' ')).length);
        if (place > 0) assert.equal(title, `Step ${place} of ${n}: remove ${plan.disassembly[place - 1]}`);
      }
      await page.getByText('Assembly', {exact: true}).click();
      for (let place = n; place >= 0; --place) {
        await setSlider(page, place);
        const {pieces, title} = await shown(page);
        assert.deepEqual(pieces, states[n - place]);
        if (place > 0) assert.equal(title, `Step ${place} of ${n}: connect ${plan.assembly[place - 1]}`);
      }
      await close(page);
    });
  }

  test('says of each step what moves, what it earns, the total and what allows it', async () => {
    const plan = JSON.parse(orasp('solve', 'hubble-upc', '--json').out);
    const page = await open(report('hubble-upc').path);
    const rows = page.locator('table.steps tbody tr');
    assert.equal(await rows.count(), plan.steps.length);
    for (const {step, connection, reward, total, moved} of plan.steps) {
      const cells = await rows.nth(step - 1).locator('td').allTextContents();
      assert.equal(cells[1], connection);
      assert.equal(cells[2], moved.length > 0 ? moved.join(', ') : '–');
      assert.ok(Math.abs(Number(cells[3].replace('−', '-')) - reward) < 1e-6);
      assert.ok(Math.abs(Number(cells[4].replace('−', '-')) - total) < 1e-6);
      assert.match(cells[6], moved.length > 0 ? new RegExp(`Moved parts moves ${moved.length} of at most 3 parts`) : /Nothing constrains it/);
    }
    await close(page);
  });

  test('says which way a piece goes and which steps are done in one go, in either order', async () => {
    const page = await open(report(shelf).path);
    const card = page.locator('.card');
    for (let i = 0; i < 5; ++i) await page.keyboard.press('ArrowRight');
    const off = 'In one go2 of 6: undo left-bottom, left-top, right-bottom, right-top; then bottom, top, back come off along +y';
    assert.ok((await card.textContent()).includes(`Along+y${off}`), await card.textContent());
    await page.keyboard.press('ArrowLeft');
    assert.ok((await card.textContent()).includes(`nothing${off}`), await card.textContent());
    await page.getByText('Assembly', {exact: true}).click();
    const on = 'In one go5 of 6: bottom, top, back come on along -y; then connect right-top, right-bottom, left-top, left-bottom';
    await page.keyboard.press('Home');
    for (let i = 0; i < 5; ++i) await page.keyboard.press('ArrowRight');
    assert.ok((await card.textContent()).includes(`Along-y${on}`), await card.textContent());
    await close(page);
  });

  test('names the step that met a precedence, in either order', async () => {
    const page = await open(report('lattice').path);
    const plan = JSON.parse(orasp('solve', 'lattice', '--json').out);
    const lattice = JSON.parse(orasp('scenarios', 'lattice').out);
    const rows = () => page.locator('table.steps tbody tr').allTextContents();
    const down = await rows();
    for (const {connection, after} of lattice.precedence) {
      const at = plan.disassembly.indexOf(connection);
      assert.ok(down[at].includes(`goes only after ${after.map((other) => `"${other}" (step ${plan.disassembly.indexOf(other) + 1})`).join(', ')}`), down[at]);
    }
    await page.getByText('Assembly', {exact: true}).click();
    const up = await rows();
    for (const {connection, after} of lattice.precedence) {
      const at = plan.assembly.indexOf(connection);
      assert.ok(up[at].includes(`is made before ${after.map((other) => `"${other}" (step ${plan.assembly.indexOf(other) + 1})`).join(', ')}`), up[at]);
    }
    await close(page);
  });

  test('adds up the rewards backwards in the other order', async () => {
    const page = await open(report('lattice').path);
    await page.getByText('Assembly', {exact: true}).click();
    const {assembly, steps, reward} = JSON.parse(orasp('solve', 'lattice', '--json').out);
    let total = 0;
    const rows = page.locator('table.steps tbody tr');
    for (let i = 0; i < assembly.length; ++i) {
      total += steps[steps.length - 1 - i].reward;
      const cells = await rows.nth(i).locator('td').allTextContents();
      assert.equal(cells[1], assembly[i]);
      assert.ok(Math.abs(Number(cells[4].replace('−', '-')) - total) < 1e-6);
    }
    assert.ok(Math.abs(total - reward) < 1e-9);
    await close(page);
  });

  test('steps by keys, by buttons and by itself', async () => {
    const page = await open(report('2x3').path);
    const place = () => page.evaluate(() => globalThis.orasp.position.place);
    await page.keyboard.press('ArrowRight');
    await page.keyboard.press('ArrowRight');
    assert.equal(await place(), 2);
    await page.keyboard.press('ArrowLeft');
    assert.equal(await place(), 1);
    await page.keyboard.press('End');
    assert.equal(await place(), 7);
    await page.keyboard.press('Home');
    assert.equal(await place(), 0);
    await page.locator('#place').focus();
    await page.keyboard.press('ArrowRight');
    assert.equal(await place(), 1, 'on the slider itself a key is one step');
    await page.getByRole('button', {name: 'Step forward'}).click();
    assert.equal(await place(), 2);
    await page.getByRole('button', {name: 'Go to step 5'}).click();
    assert.equal(await place(), 5);
    await page.getByRole('button', {name: 'To the start'}).click();
    await page.locator('#speed').selectOption('20');
    await page.getByRole('button', {name: 'Play', exact: true}).click();
    await page.getByRole('button', {name: 'Pause'}).waitFor();
    await page.waitForFunction(() => globalThis.orasp.position.place === 7);
    await page.getByRole('button', {name: 'Play', exact: true}).waitFor();
    await page.locator('h1').click();
    await page.keyboard.press(' ');
    await page.waitForFunction(() => globalThis.orasp.player.playing && globalThis.orasp.position.place > 1);
    await page.keyboard.press(' ');
    assert.equal(await page.evaluate(() => globalThis.orasp.player.playing), false);
    await close(page);
  });

  test('tells a screen reader each step', async () => {
    const page = await open(report('2x3').path);
    await page.keyboard.press('End');
    const {disassembly} = JSON.parse(orasp('solve', '2x3', '--json').out);
    const said = new RegExp(`^Step 7 of 7: remove ${disassembly[6]}`);
    assert.match(await page.locator('[aria-live]').textContent(), said);
    assert.match(await page.locator('#place').getAttribute('aria-valuetext'), said);
    await close(page);
  });

  test('is dark where the system is, and switches', async () => {
    const page = await open(report('2x3').path, {colorScheme: 'dark'});
    const background = () => page.evaluate(() => getComputedStyle(document.body).backgroundColor);
    const dark = await background();
    await shot(page, 'dark');
    await page.getByRole('button', {name: 'Switch between light and dark'}).click();
    const light = await background();
    assert.notEqual(dark, light);
    await close(page);
  });

  test('shows hostile names as they are', async () => {
    const script = '<script>alert(1)</script>';
    const names = [script, 'b\u202eevil', 'x'.repeat(120), '\u65e5\u672c\u8a9e', '{{5*5}}${7*7}', '</script><!--<script>', '&lt;b&gt;'];
    const problem = {
      format: 'orasp-problem/1',
      name: '<img src=x onerror=alert(2)> </title><script>alert(3)</script>',
      note: '</script><style>*{display:none}</style>',
      parts: names.map((id, i) => ({id, name: i === 1 ? '</script><!--' : ''})),
      connections: names.slice(1).map((id, i) => ({id: i === 2 ? '--><b>bold' : `${i}<i>`, parts: [names[i], id]})),
      precedence: [{connection: '--><b>bold', after: ['0<i>']}],
    };
    const path = report(file('hostile.json', JSON.stringify(problem)), '--title', '"><script>alert(4)</script>').path;
    const page = await open(path);
    assert.equal(await page.title(), '"><script>alert(4)</script>');
    assert.equal(await page.locator('h1').textContent(), '"><script>alert(4)</script>');
    assert.equal(await page.locator('#page script, #page img, #page style, #page i').count(), 0);
    await page.keyboard.press('End');
    await page.keyboard.press('ArrowLeft');
    assert.ok((await page.locator('.pieces').textContent()).includes(script));
    const drawn = await page.evaluate(() => globalThis.orasp.views[0].graph.nodes.map((node) => node.data('label')));
    assert.deepEqual(drawn, names);
    await shot(page, 'hostile', {fullPage: true});
    await page.setViewportSize({width: 390, height: 844});
    assert.ok(await page.evaluate(() => document.documentElement.scrollWidth) <= 390);
    await shot(page, 'hostile-phone', {fullPage: true});
    await close(page);
  });

  test('plays 180 parts and 256 connections smoothly', async () => {
    const {path, seconds} = report('jwst-upc');
    console.log(`jwst-upc: written in ${seconds.toFixed(2)} s`);
    const page = await open(path);
    await page.locator('#plan').scrollIntoViewIfNeeded();
    await page.locator('#speed').selectOption('20');
    const measured = await page.evaluate(() => new Promise((done) => {
      const {player, position} = globalThis.orasp;
      const times = [];
      player.start();
      const tick = (now) => {
        times.push(now);
        if (position.place < 100) requestAnimationFrame(tick);
        else done({frames: times.length - 1, seconds: (times.at(-1) - times[0]) / 1000, steps: position.place});
      };
      requestAnimationFrame(tick);
    }));
    console.log(`jwst-upc: ${(measured.frames / measured.seconds).toFixed(1)} frames a second over ${measured.steps} steps at 20 a second`);
    assert.ok(measured.frames > measured.steps, 'frames are drawn between the steps');
    await shot(page, 'jwst-upc');
    await page.keyboard.press('End');
    assert.equal((await shown(page)).written, 180);
    await close(page);
  });

  test('shows several plans side by side, at the same place', async () => {
    const best = file('best.json', orasp('solve', 'lattice', '--json').out);
    const greedy = file('greedy.json', orasp('solve', 'lattice', '--method', 'greedy', '--json').out);
    const page = await open(report('lattice', best, greedy).path);
    assert.equal(await page.locator('.plan').count(), 2);
    await setSlider(page, 6);
    for (const [i, path] of [best, greedy].entries()) {
      const plan = JSON.parse(readFileSync(path, 'utf8'));
      assert.deepEqual((await shown(page, i)).pieces, piecesOf(JSON.parse(orasp('scenarios', 'lattice').out), plan.disassembly)[6]);
    }
    const table = await page.locator('#comparison tbody tr').allTextContents();
    assert.match(table[0], /optimal/);
    assert.match(table[1], /feasible/);
    await shot(page, 'side-by-side', {fullPage: true});
    await close(page);
  });

  test('marks what an invalid plan breaks, and the exit code says so', async () => {
    const {path, code} = report(shelf, shelfWrong);
    assert.equal(code, 10);
    const page = await open(path);
    assert.equal(await page.locator('.status').first().textContent(), 'not valid');
    assert.equal(await page.locator('.violations li').count(), 2);
    await page.keyboard.press('ArrowRight');
    assert.match(await page.locator('.card').textContent(), /Broken: Precedence/);
    await shot(page, 'not-valid', {fullPage: true});
    await close(page);
  });

  test('draws H with the plan and what a precedence prunes', async () => {
    const page = await open(report('2x3').path);
    await page.locator('#states').scrollIntoViewIfNeeded();
    const {states, actions} = JSON.parse(orasp('graph', '2x3', '--json').out);
    const drawing = await page.evaluate(() => {
      const {nodes, actions: edges, paths} = globalThis.orasp.data.graph.drawing;
      return {states: nodes.filter(([, , kind]) => kind !== 1).length, pruned: nodes.filter(([, , kind]) => kind === 1).length, actions: edges.filter((edge) => edge[4] === 0).length, path: paths[0].map((node) => nodes[node][0])};
    });
    assert.deepEqual(drawing, {states, pruned: 128 - states, actions, path: [0, 1, 2, 3, 4, 5, 6, 7]});
    await page.waitForSelector('#states canvas');
    await page.keyboard.press('ArrowRight');
    await page.locator('#states .frame').hover({position: {x: 400, y: 300}});
    await shot(page, 'states');
    await close(page);
  });

  test('shows a learning curve and a distribution with the plan and the optimum', async () => {
    const log = file('log.jsonl', [...Array(40).keys()].map((i) => JSON.stringify({episodes: 8 * i, updates: i, epsilon: 0.5, loss: 0.1, greedy: -1.5 + i / 100, best_greedy: -1.4 + i / 100, best: -1.1 + i / 400, bound: -0.9902, seconds: i})).join('\n'));
    const sample = file('sample.json', orasp('sample', 'hubble', '-n', '300', '--json').out);
    const page = await open(report('hubble', '--log', log, '--sample', sample).path);
    assert.equal(await page.locator('#learning .chart path.series').count(), 3);
    assert.equal(await page.locator('#distribution path.violin').count(), 1);
    assert.equal(await page.locator('#distribution .mark-plan').count(), 1);
    assert.match(await page.locator('#distribution').textContent(), /optimum −0\.9902/);
    await page.locator('#learning').scrollIntoViewIfNeeded();
    await shot(page, 'learning');
    await page.locator('#distribution').scrollIntoViewIfNeeded();
    await shot(page, 'distribution');
    await close(page);
  });

  test('draws parts with positions in space', async () => {
    const page = await open(report(lego[1] ?? shelf).path);
    await setSlider(page, 5);
    await page.waitForTimeout(600);
    const colours = await page.evaluate(() => {
      const canvas = document.querySelector('.space-canvas');
      const copy = document.createElement('canvas');
      copy.width = canvas.width;
      copy.height = canvas.height;
      const context = copy.getContext('2d');
      context.drawImage(canvas, 0, 0);
      return new Set(new Uint32Array(context.getImageData(0, 0, copy.width, copy.height).data.buffer)).size;
    });
    assert.ok(colours > 10, 'something is drawn');
    await shot(page, 'space');
    await page.getByRole('button', {name: 'Graph', exact: true}).click();
    assert.ok(await page.locator('.canvas:not(.space) canvas').first().isVisible());
    await close(page);
  });

  test('shows a problem without a plan, and why', async () => {
    const problem = JSON.parse(orasp('scenarios', '2x3').out);
    problem.precedence = [{connection: '1-2', after: ['2-3']}, {connection: '2-3', after: ['1-2']}];
    const {path, code} = report(file('cycle.json', JSON.stringify(problem)));
    assert.equal(code, 10);
    const page = await open(path);
    assert.match(await page.locator('header').textContent(), /No plan exists/);
    assert.equal(await page.locator('#about ul').first().locator('li').count(), 2);
    await close(page);
  });

  test('opens for problems without parts, without connections and with one connection', async () => {
    for (const [parts, connections] of [[[], []], [[{id: 'a'}], []], [[{id: 'a'}, {id: 'b'}], [{parts: ['a', 'b']}]]]) {
      const page = await open(report(file('small.json', JSON.stringify({format: 'orasp-problem/1', parts, connections}))).path);
      await page.keyboard.press('End');
      await close(page);
    }
  });

  test('counts an assembly problem in its own direction', async () => {
    const page = await open(report('2x3', '--direction', 'assembly').path);
    const plan = JSON.parse(orasp('solve', '2x3', '--direction', 'assembly', '--json').out);
    await page.keyboard.press('ArrowRight');
    const {title, pieces} = await shown(page);
    assert.equal(title, `Step 1 of 7: connect ${plan.assembly[0]}`);
    assert.equal(pieces.length, 5);
    await page.keyboard.press('End');
    assert.equal((await shown(page)).pieces.length, 1);
    const last = await page.locator('table.steps tbody tr').last().locator('td').nth(4).textContent();
    assert.ok(Math.abs(Number(last.replace('−', '-')) - plan.reward) < 1e-6);
    await close(page);
  });

  test('shows what each robot of a fleet does and what stands where', async () => {
    const plan = JSON.parse(orasp('solve', 'fleet-lattice', '--json').out);
    const page = await open(report('fleet-lattice').path);
    const n = plan.steps.length;
    assert.equal(await page.locator('table.lanes tbody tr').count(), 4 + 1 + 4);
    for (let step = 1; step <= n; ++step) {
      await page.keyboard.press('ArrowRight');
      const {title} = await shown(page);
      assert.equal(title, `Step ${step} of ${n}: remove ${plan.steps[step - 1].connections.join(', ')}`);
      for (const {robots, parts, to} of plan.steps[step - 1].moves) {
        for (const [i, robot] of robots.entries()) {
          const cell = await page.locator('table.lanes tbody tr').nth(robot - 1).locator('td').nth(step - 1).textContent();
          assert.ok(cell.startsWith(parts[i]) && cell.includes(to), cell);
        }
      }
    }
    assert.equal((await shown(page)).pieces.length, 9);
    await setSlider(page, 2);
    await shot(page, 'fleet', {fullPage: true});
    await page.getByText('Assembly', {exact: true}).click();
    assert.match((await shown(page)).title, /connect/);
    await close(page);
  });

  test('fits a phone', async () => {
    for (const problem of ['hubble', 'jwst-upc', shelf]) {
      const page = await open(report(problem).path, {viewport: {width: 390, height: 844}, isMobile: true, hasTouch: true});
      assert.ok(await page.evaluate(() => document.documentElement.scrollWidth) <= 390, problem);
      await setSlider(page, 3);
      await page.evaluate(() => document.getElementById('plan').scrollIntoView());
      await shot(page, `phone-${problem === shelf ? 'shelf' : problem}`);
      await close(page);
    }
  });

  test('prints every step and leaves the buttons out', async () => {
    const page = await open(report('jwst-upc').path, {colorScheme: 'dark'});
    await setSlider(page, 40);
    await page.emulateMedia({media: 'print'});
    assert.equal(await page.locator('.player').isVisible(), false);
    assert.equal(await page.locator('.scroller.long').first().evaluate((box) => box.scrollHeight > box.clientHeight + 1), false);
    assert.equal(await page.evaluate(() => document.documentElement.dataset.theme), 'light');
    assert.ok(await page.locator('.printed img').first().evaluate((image) => image.naturalWidth > 100));
    await page.pdf({path: join(artefacts, 'print.pdf'), format: 'A4', printBackground: true});
    await shot(page, 'print');
    await close(page);
  });

  test('has no accessibility violation of level A and AA', async () => {
    const best = file('best2.json', orasp('solve', 'lattice', '--json').out);
    const greedy = file('greedy2.json', orasp('solve', 'lattice', '--method', 'greedy', '--json').out);
    const pages = [
      ['2x3', [report('2x3', '--sample-count', '200').path, {}]],
      ['2x3, dark', [report('2x3', '--sample-count', '200').path, {colorScheme: 'dark'}]],
      ['shelf, not valid', [report(shelf, shelfWrong).path, {}]],
      ['shelf, not valid, dark', [report(shelf, shelfWrong).path, {colorScheme: 'dark'}]],
      ['side by side', [report('lattice', best, greedy).path, {}]],
      ['jwst-upc', [report('jwst-upc').path, {}]],
      ['fleet-lattice', [report('fleet-lattice').path, {}]],
      ['hubble on a phone', [report('hubble').path, {viewport: {width: 390, height: 844}}]],
    ];
    for (const [name, [path, options]] of pages) {
      const page = await open(path, options);
      await page.keyboard.press('ArrowRight');
      await page.keyboard.press('ArrowRight');
      await page.evaluate(axeSource);
      const {violations} = await page.evaluate(() => globalThis.axe.run(document, {runOnly: ['wcag2a', 'wcag2aa', 'wcag21a', 'wcag21aa', 'wcag22aa']}));
      assert.deepEqual(violations.map(({id, nodes}) => `${name}: ${id}: ${nodes.slice(0, 3).map(({html, failureSummary}) => `${html.slice(0, 160)} ${failureSummary}`).join(' | ')}`), []);
      await close(page);
    }
  });
});
