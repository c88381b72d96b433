// The instruction book of a plan: a page for each step, in the order of assembly, with a picture of what is added and the parts
// it takes. Shown instead of the report; the browser prints it or saves it as PDF, a page each.
import {fill, h, id} from './dom.js';
import {counted} from './format.js';
import {byKind, kindText, kindsOf} from './kinds.js';
import {Replay, cutOf} from './replay.js';
import {wayOf} from './words.js';

const [width, height] = [1280, 860];

export class Book {
  /** `space`: the true parts in space; `title` of the report. */
  constructor(problem, plan, space, title) {
    Object.assign(this, {problem, plan, space, title, kinds: kindsOf(problem)});
    this.leaves = h('div', {class: 'leaves'});
    this.closeButton = h('button', {type: 'button', onclick: () => this.close()}, 'Back to the report');
    this.progress = h('span', {class: 'quiet', role: 'status'});
    this.element = h('section', {class: 'book', hidden: true, 'aria-label': 'Instruction book'},
      h('div', {class: 'book-bar'}, this.closeButton, h('button', {type: 'button', onclick: () => print()}, 'Print, or save as PDF'), this.progress),
      this.leaves);
    this.element.addEventListener('keydown', (event) => {
      if (event.key === 'Escape') this.close();
    });
  }

  async open(opener) {
    this.opener = opener;
    this.element.hidden = false;
    document.documentElement.dataset.view = 'book';
    scrollTo(0, 0);
    this.closeButton.focus({preventScroll: true});
    if (this.made) return;
    this.made = true;
    const drawings = this.write();
    const pictures = this.space.pictures(width, height);
    pictures.begin();
    // A picture at a time, so that the page stays alive.
    for (let i = 0; i < drawings.length; ++i) {
      this.progress.textContent = `Drawing ${i + 1} of ${drawings.length}`;
      const [image, draw] = drawings[i];
      image.src = draw(pictures);
      await image.decode();
      await new Promise((done) => setTimeout(done));
    }
    pictures.end();
    this.progress.textContent = counted(this.pages, 'page');
    this.element.dataset.ready = 'true';
  }

  close() {
    this.element.hidden = true;
    delete document.documentElement.dataset.view;
    this.opener?.focus();
  }

  /** What is needed, by kind: count and name, cut after `most` kinds. */
  partTable(parts, label, most) {
    const all = byKind(this.kinds, parts);
    const rows = all.slice(0, all.length > most + 1 ? most : all.length).map(({name, parts: equal}) => h('tr', {}, h('td', {class: 'num'}, `${equal.length} ×`), h('td', {}, id(name))));
    if (rows.length < all.length) rows.push(h('tr', {}, h('td', {colspan: 2}, `and ${all.length - rows.length} more kinds`)));
    return h('table', {class: 'needed', 'aria-label': label}, h('thead', {class: 'unseen'}, h('tr', {}, h('th', {scope: 'col'}, 'Number'), h('th', {scope: 'col'}, 'Part'))), h('tbody', {}, rows));
  }

  /** Writes all pages; returns for each picture [image, how to draw it]. */
  write() {
    const {problem, plan, space} = this;
    const moves = space.moves.slice().reverse();
    const total = moves.length;
    const drawings = [];
    const picture = (alt, draw) => {
      const image = h('img', {alt, width, height});
      drawings.push([image, draw]);
      return h('div', {class: 'picture'}, image);
    };
    const everything = problem.parts.map((_, part) => part);
    const leaf = (title, number, ...children) => h('article', {class: 'leaf', 'aria-label': title}, children, h('p', {class: 'leaf-foot'}, h('span', {}, id(this.title)), h('span', {}, String(number))));
    const cover = leaf('Cover', 1,
      h('h1', {}, id(this.title)),
      h('p', {class: 'lead'}, `${counted(problem.parts.length, 'part')}, ${counted(total, 'step')}`),
      h('div', {class: 'covers'}, picture('The finished product', (pictures) => pictures.whole(0)), picture('All its parts, apart', (pictures) => pictures.whole(1))),
      h('h2', {}, 'Parts'), this.partTable(everything, 'All parts', Infinity));
    const replay = new Replay(problem, plan);
    const leaves = moves.map((move, i) => {
      const step = plan.steps[move.step];
      replay.goTo(move.step + 1);
      const labels = new Set([step.split[0], ...(step.rest ?? []).map(([label]) => label)]);
      const moved = new Set(step.moved);
      const rest = everything.filter((part) => labels.has(replay.labels[part]) && !moved.has(part));
      const [first, end] = (plan.operations ?? []).find(([from, to]) => from <= move.step && move.step < to) ?? [move.step, move.step + 1];
      const made = plan.steps.slice(first, end).flatMap(cutOf).map((c) => problem.connections[c][0]);
      const kinds = byKind(this.kinds, step.moved);
      const named = kinds.slice(0, 3).map(kindText).join(', ') + (kinds.length > 3 ? ', …' : '');
      const along = step.way ? wayOf(step, 'assembly') : null;
      const whatFirst = i === 0 ? [h('p', {}, 'To: ', id(byKind(this.kinds, rest).map(kindText).join(', ')))] : [];
      return leaf(`Step ${i + 1} of ${total}`, i + 2,
        h('h2', {}, h('span', {class: 'step-number'}, String(i + 1)), h('span', {class: 'of'}, ` of ${total}`)),
        h('p', {class: 'lead'}, step.moved.length > 1 ? `Add the subassembly of ${counted(step.moved.length, 'part')}: ` : 'Add ', id(named), along ? [', along ', id(along)] : ''),
        whatFirst,
        picture(`Step ${i + 1}: ${named} comes on${along ? ` along ${along}` : ''}; what is there already is pale`, (pictures) => pictures.step(move, rest)),
        h('div', {class: 'leaf-facts'},
          h('div', {}, h('h3', {}, 'Parts'), this.partTable(step.moved, `Parts of step ${i + 1}`, 10)),
          h('div', {}, h('h3', {}, 'Connect'), h('ul', {}, made.slice(0, 8).map((name) => h('li', {}, id(name))), made.length > 8 ? h('li', {}, `and ${made.length - 8} more`) : null))));
    });
    this.pages = leaves.length + 1;
    fill(this.leaves, cover, leaves);
    return drawings;
  }
}
