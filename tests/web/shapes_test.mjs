// The true parts in the page, and its book, in a real Chromium. Screenshots go to ORASP_ARTEFACTS.
import assert from 'node:assert/strict';
import {readFileSync} from 'node:fs';
import {join} from 'node:path';
import test, {after, before, describe} from 'node:test';
import {byKind, kindText, kindsOf} from '../../web/src/kinds.js';
import {artefacts, axeSource, close, file, open, orasp, report, setSlider, shot, start, stop} from './browser.mjs';
import {balls, boxProblem, cabinet, cabinetFile, changed, overlap} from './products.mjs';

before(start);
after(stop);

const quick = ['--time-limit', '5'];

/** A report on the cabinet. */
function cabinetReport(more = {}) {
  file('cabinet.glb', cabinetFile());
  return report(file('cabinet.json', JSON.stringify(boxProblem(cabinet, more))), ...quick);
}

const byPart = {action: 'part', objective: {type: 'completion'}};

/** What moves in each step, and where each part is then, at `samples` places of its way out: lists of triangles. */
const waysOut = (page, samples) => page.evaluate((count) => {
  const {views, data, position} = globalThis.orasp;
  const {inSpace, plan} = views[0];
  const ways = [];
  for (const move of inSpace.moves) {
    position.set(move.step + 1, 'disassembly');
    const step = plan.steps[move.step];
    const labels = [step.split[0], ...(step.rest ?? []).map(([label]) => label)];
    const rest = data.problem.parts.map((_, part) => part).filter((part) => labels.includes(views[0].replay.labels[part]) && !step.moved.includes(part));
    const places = [];
    for (let i = 0; i <= count; ++i) {
      inSpace.place(0, i / count);
      places.push(step.moved.map((part) => inSpace.triangles(part)));
    }
    ways.push({moved: step.moved, rest, way: step.way?.[2], out: move.out, places});
  }
  return ways;
}, samples);

/** Whether a triangle reaches into a box: no axis parts the two (Akenine-Moeller, Fast 3D triangle-box overlap testing, 2001). */
function reachesInto(triangle, {low, high}) {
  const middle = low.map((x, k) => (x + high[k]) / 2);
  const half = low.map((x, k) => (high[k] - x) / 2 - 1e-4);
  const points = [0, 1, 2].map((i) => [0, 1, 2].map((k) => triangle[3 * i + k] - middle[k]));
  const sides = [0, 1, 2].map((i) => points[i].map((x, k) => points[(i + 1) % 3][k] - x));
  const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
  const units = [[1, 0, 0], [0, 1, 0], [0, 0, 1]];
  const all = [...units, cross(sides[0], sides[1]), ...units.flatMap((one) => sides.map((side) => cross(one, side)))];
  return all.every((axis) => {
    const reach = axis.reduce((sum, x, k) => sum + Math.abs(x) * half[k], 0);
    const seen = points.map((point) => point.reduce((sum, x, k) => sum + x * axis[k], 0));
    return Math.hypot(...axis) < 1e-12 || (Math.min(...seen) < reach && Math.max(...seen) > -reach);
  });
}

const trianglesOf = (list) => [...Array(list.length / 9).keys()].map((i) => list.slice(9 * i, 9 * i + 9));

/** How many colours a picture has, and how much of it is not white. */
const looksOf = (page, selector) => page.evaluate(async (wanted) => Promise.all([...document.querySelectorAll(wanted)].map(async (image) => {
  await image.decode?.();
  const copy = document.createElement('canvas');
  copy.width = image.naturalWidth ?? image.width;
  copy.height = image.naturalHeight ?? image.height;
  const context = copy.getContext('2d');
  context.drawImage(image, 0, 0);
  const pixels = new Uint32Array(context.getImageData(0, 0, copy.width, copy.height).data.buffer);
  return {width: copy.width, colours: new Set(pixels).size, drawn: pixels.filter((pixel) => pixel >>> 24 > 8).length / pixels.length};
})), selector);

const setApart = (page, share) => page.locator('.apart').evaluate((slider, value) => {
  slider.value = String(value);
  slider.dispatchEvent(new Event('input', {bubbles: true}));
}, 1000 * share);

describe('The true parts', () => {
  for (const [name, more] of [['connections', {}], ['parts', byPart]]) {
    test(`leave along the direction of their step and meet nothing on the way, where steps take ${name}`, async () => {
      const page = await open(cabinetReport(more).path, {reducedMotion: 'reduce'});
      const ways = await waysOut(page, 16);
      assert.equal(ways.length, cabinet.length - 1);
      for (const {moved, rest, way, out, places} of ways) {
        assert.ok(way && out > 0);
        const [low, high] = [Math.min, Math.max].map((pick, end) => (boxes) => [0, 1, 2].map((k) => pick(...boxes.map((box) => [box.low, box.high][end][k]))));
        places.forEach((place, i) => place.forEach((triangles, at) => {
          const {id, boxes} = cabinet[moved[at]];
          // It is where it should be, ...
          for (let k = 0; k < 3; ++k) {
            const xs = triangles.filter((_, j) => j % 3 === k);
            assert.ok(Math.abs(Math.min(...xs) - low(boxes)[k] - (way[k] * out * i) / 16) < 1e-4);
            assert.ok(Math.abs(Math.max(...xs) - high(boxes)[k] - (way[k] * out * i) / 16) < 1e-4);
          }
          // ... in nobody's way, ...
          for (const other of rest) for (const triangle of trianglesOf(triangles)) assert.ok(cabinet[other].boxes.every((box) => !reachesInto(triangle, box)), `${id} meets ${cabinet[other].id}`);
        }));
        // ... and at the end beyond all that stays.
        const seen = (point) => point.reduce((sum, x, k) => sum + x * way[k], 0);
        const ends = (list) => list.flatMap((at) => cabinet[at].boxes).flatMap((box) => [seen(box.low), seen(box.high)]);
        assert.ok(Math.min(...ends(moved)) + out > Math.max(...ends(rest)));
      }
      await close(page);
    });
  }

  test('come apart by the slider, one after the other, and none passes through another', async () => {
    for (const more of [{}, byPart, {...byPart, direction: 'assembly'}]) {
      const page = await open(cabinetReport(more).path, {reducedMotion: 'reduce'});
      const {frames, n} = await page.evaluate(() => {
        const {inSpace} = globalThis.orasp.views[0];
        const list = [];
        const samples = 24 * inSpace.moves.length;
        for (let i = 0; i <= samples; ++i) {
          inSpace.place(i / samples, 0);
          list.push(inSpace.offsets.map((offset) => offset.slice()));
        }
        return {frames: list, n: inSpace.moves.length};
      });
      assert.equal(n, cabinet.length - 1);
      for (const offsets of frames) {
        const now = cabinet.map((part, at) => changed(part, (low, high) => ({low: low.map((x, k) => x + offsets[at][k]), high: high.map((x, k) => x + offsets[at][k])})));
        now.forEach((a, i) => now.slice(i + 1).forEach((b) => assert.ok(!overlap(a, b, 1e-6), `${a.id} passes through ${b.id}`)));
      }
      const last = frames.at(-1);
      assert.ok(last.filter((offset) => Math.hypot(...offset) > 0.01).length >= cabinet.length - 1);
      await close(page);
    }
  });

  test('are drawn whole, half apart and apart, with labels on demand, in light and dark', async () => {
    const {path} = cabinetReport(byPart);
    for (const colorScheme of ['light', 'dark']) {
      const page = await open(path, {colorScheme, reducedMotion: 'reduce'});
      assert.match(await page.locator('.frame').first().getAttribute('aria-label'), /^The true parts in space/);
      for (const share of [0, 0.5, 1]) {
        await setApart(page, share);
        const [{colours, drawn}] = await looksOf(page, '.space-canvas');
        assert.ok(colours > 50 && drawn > 0.03 && drawn < 0.8, `${colours} colours on ${drawn}`);
        assert.equal(await page.locator('.apart').getAttribute('aria-valuetext'), `${Math.round(13 * share)} of 13 pieces out`);
        await shot(page, `cabinet-${colorScheme}-${share}`);
      }
      assert.equal(await page.locator('.space-label:visible').count(), 0);
      await page.getByRole('button', {name: 'Labels'}).click();
      assert.ok(await page.locator('.space-label:visible').count() >= 8);
      await shot(page, `cabinet-${colorScheme}-labels`);
      await setApart(page, 0);
      for (const place of [3, 7, 12]) {
        await setSlider(page, place);
        await shot(page, `cabinet-${colorScheme}-step-${place}`);
      }
      await close(page);
    }
  });

  test('move by themselves and by keys, in either order', async () => {
    const page = await open(cabinetReport(byPart).path);
    const out = () => page.evaluate(() => Math.max(...globalThis.orasp.views[0].inSpace.offsets.map((offset) => Math.hypot(...offset))));
    await page.keyboard.press('ArrowRight');
    await page.waitForFunction(() => globalThis.orasp.views[0].inSpace.offsets.some((offset) => Math.hypot(...offset) > 0.01));
    await page.waitForTimeout(1500);
    const far = await out();
    assert.ok(far > 0.02);
    await page.getByText('Assembly', {exact: true}).click();
    await page.keyboard.press('ArrowLeft');
    await page.keyboard.press('ArrowRight');
    await page.waitForTimeout(2500);
    assert.ok(await out() < 1e-9, 'the piece has come on');
    await page.locator('.apart').focus();
    await page.keyboard.press('End');
    assert.ok(await out() > far);
    await close(page);
  });

  test('are counted where they are equal', async () => {
    const page = await open(cabinetReport(byPart).path, {reducedMotion: 'reduce'});
    assert.match(await page.locator('.pieces').textContent(), /14 parts floor, 2 × wall, back, roof, tray, front, 2 × block, 4 × foot, knob/);
    await close(page);
  });

  test('give way to boxes, with a word in the page, where their file is missing or damaged', async () => {
    const problem = file('without.json', JSON.stringify(boxProblem(cabinet, {geometry: {file: 'nowhere.glb'}})));
    const page = await open(report(problem, ...quick).path);
    assert.equal(await page.locator('.fault').textContent(), 'The true parts are not shown: "nowhere.glb" cannot be read.');
    assert.equal(await page.locator('.apart').count(), 0);
    await setSlider(page, 2);
    await close(page);
    file('cut.glb', cabinetFile().subarray(0, 1000));
    const {err} = orasp('report', file('cut.json', JSON.stringify(boxProblem(cabinet, {geometry: {file: 'cut.glb'}}))), ...quick, '-o', file('cut.html'));
    assert.match(err, /geometry: "cut\.glb": it is cut off after 1000 of its [\d,]+ bytes; the report does without/);
    assert.match(readFileSync(file('cut.html'), 'utf8'), /The true parts are not shown: \\"cut\.glb\\": it is cut off/);
  });
});

test('Equal parts have one name, or ids that differ in a number at the end, and weigh the same', () => {
  const parts = [
    ['nut.1', '', 0.2], ['nut.2', '', 0.2], ['nut.3', '', 0.3], ['Profile 20', '', 1], ['Profile 40', '', 1], ['Rod 1', '', 2], ['Rod 2', '', 2],
    ['a', 'plate', 1], ['b', 'plate', 1], ['7', '', 1], ['8', '', 1], ['Bearing 5 x 16 (1)', '', 3], ['Bearing 5 x 16 (2)', '', 3],
    ['Shim 10 x 5', '', 4], ['Shim 10 x 5 2', '', 4], ['Ring 16 x 5', '', 5], ['Ring 16 x 5 2', 'Ring 16 x 5', 5],
  ];
  const texts = byKind(kindsOf({parts}), parts.map((_, part) => part)).map(kindText);
  assert.deepEqual(texts, ['2 × nut', 'nut.3', 'Profile 20', 'Profile 40', '2 × Rod', '2 × plate', '7', '8', '2 × Bearing 5 x 16', '2 × Shim 10 x 5', '2 × Ring 16 x 5']);
});

test('A product that is stated goes before names, ids and masses', () => {
  const parts = [['a', 'nut', 1, null, 'M5 nut'], ['b', '', 2, null, 'M5 nut'], ['nut.1', '', 0.2, null, 'M4 nut'], ['nut.2', '', 0.2], ['nut.3', '', 0.2]];
  const texts = byKind(kindsOf({parts}), parts.map((_, part) => part)).map(kindText);
  assert.deepEqual(texts, ['2 × M5 nut', 'nut.1', '2 × nut']);
});

describe('The book', () => {
  test('has a cover and a page for each step, with a picture and the parts, and goes back', async () => {
    const page = await open(cabinetReport(byPart).path, {colorScheme: 'dark'});
    await page.keyboard.press('ArrowRight');
    const button = page.getByRole('button', {name: 'Book'});
    await button.click();
    await page.waitForSelector('.book[data-ready]');
    const n = cabinet.length - 1;
    assert.equal(await page.locator('.leaf').count(), 1 + n);
    assert.equal(await page.locator('.leaf img').count(), 2 + n);
    for (const {width, colours, drawn} of await looksOf(page, '.leaf img')) assert.ok(width === 1280 && colours > 20 && drawn > 0.01, `${width} ${colours} ${drawn}`);
    const {assembly} = JSON.parse(orasp('solve', file('cabinet.json'), ...quick, '--json').out);
    assert.equal(assembly.length, n);
    const leaves = await page.locator('.leaf').allTextContents();
    assert.match(leaves[0], /Cabinet14 parts, 13 steps/);
    assert.match(leaves[0], /4 ×foot/);
    assembly.forEach((made, i) => {
      assert.ok(leaves[i + 1].startsWith(`${i + 1} of ${n}`), leaves[i + 1]);
      for (const connection of made.slice(0, 8)) assert.ok(leaves[i + 1].includes(connection), leaves[i + 1]);
    });
    assert.equal(await page.locator('#plan').isVisible(), false);
    await shot(page, 'book-cover');
    await page.locator('.leaf').nth(6).scrollIntoViewIfNeeded();
    await page.locator('.leaf').nth(6).screenshot({path: join(artefacts, 'book-step.png')});
    await page.evaluate(axeSource);
    const {violations} = await page.evaluate(() => globalThis.axe.run(document, {runOnly: ['wcag2a', 'wcag2aa', 'wcag21a', 'wcag21aa', 'wcag22aa']}));
    assert.deepEqual(violations.map(({id, nodes}) => `${id}: ${nodes[0].html.slice(0, 160)} ${nodes[0].failureSummary}`), []);
    const pdf = await page.pdf({path: join(artefacts, 'book.pdf'), format: 'A4', printBackground: true});
    assert.equal(pdf.toString('latin1').match(/\/Type\s*\/Page\b(?!s)/g).length, 1 + n);
    await page.keyboard.press('Escape');
    assert.ok(await page.locator('#plan').isVisible());
    assert.equal(await page.evaluate(() => document.activeElement.textContent), 'Book');
    await shot(page, 'book-closed');
    await close(page);
  });
});

describe('A page with shapes', () => {
  test('has no accessibility violation of level A and AA', async () => {
    for (const colorScheme of ['light', 'dark']) {
      const page = await open(cabinetReport(byPart).path, {colorScheme, reducedMotion: 'reduce'});
      await page.keyboard.press('ArrowRight');
      await page.getByRole('button', {name: 'Labels'}).click();
      await setApart(page, 1);
      await page.evaluate(axeSource);
      const {violations} = await page.evaluate(() => globalThis.axe.run(document, {runOnly: ['wcag2a', 'wcag2aa', 'wcag21a', 'wcag21aa', 'wcag22aa']}));
      assert.deepEqual(violations.map(({id, nodes}) => `${id}: ${nodes[0].html.slice(0, 160)} ${nodes[0].failureSummary}`), []);
      await close(page);
    }
  });

  test('fits a phone', async () => {
    const page = await open(cabinetReport(byPart).path, {viewport: {width: 390, height: 844}, isMobile: true, hasTouch: true, reducedMotion: 'reduce'});
    assert.ok(await page.evaluate(() => document.documentElement.scrollWidth) <= 390);
    await page.evaluate(() => document.getElementById('plan').scrollIntoView());
    await setApart(page, 1);
    await shot(page, 'cabinet-phone');
    await close(page);
  });

  test('stays below 10 MB with 100 parts of 20,000 triangles each', async () => {
    const {problem, file: shapes} = balls(100, 20_000);
    problem.parts.forEach((part, i) => (part.position = [0.03 * (i % 10), 0.03 * Math.floor(i / 10), 0]));
    file('balls.glb', shapes);
    const {path, bytes, seconds} = report(file('balls.json', JSON.stringify(problem)), '--time-limit', '0.2');
    console.log(`100 parts of 20,000 triangles: ${(bytes / 1e6).toFixed(2)} MB, written in ${seconds.toFixed(1)} s`);
    assert.ok(bytes < 10e6);
    const page = await open(path, {reducedMotion: 'reduce'});
    const rate = await page.evaluate(() => new Promise((done) => {
      const {inSpace} = globalThis.orasp.views[0];
      const begin = performance.now();
      let frames = 0;
      const tick = () => {
        inSpace.explode((++frames % 100) / 100);
        inSpace.renderer.getContext().finish();
        if (performance.now() - begin < 3000) requestAnimationFrame(tick);
        else done((1000 * frames) / (performance.now() - begin));
      };
      requestAnimationFrame(tick);
    }));
    console.log(`100 parts, drawn without a graphics card: ${rate.toFixed(1)} frames a second`);
    await setApart(page, 1);
    await shot(page, 'balls');
    await close(page);
  });
});
