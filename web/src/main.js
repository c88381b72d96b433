// The page of `orasp report`. The data stand in the page as JSON (src/orasp/io/report.cpp writes them); everything here
// arranges and draws, and works out nothing about assemblies.
import {AssemblyGraph, layOut} from './assembly.js';
import {Book} from './book.js';
import {lineChart, lineKey, violin} from './charts.js';
import {fill, h, id} from './dom.js';
import {column, constraintName, counted, grouped, number} from './format.js';
import {byKind, kindText, kindsOf} from './kinds.js';
import {Player} from './player.js';
import {Position, Replay, cutOf, index} from './replay.js';
import {StateGraph, stateWords} from './states.js';
import {colours, isDark, onPrint, onTheme, pieceColour, startTheme, toggleTheme} from './theme.js';
import {act, cutList, movement, operationWords, partList, partName, reasonList, wayOf} from './words.js';

const data = JSON.parse(document.getElementById('data').textContent);
const {problem, plans, best} = data;
const placed = problem.parts.length > 0 && problem.parts.every((part) => part[3]) && typeof globalThis.oraspSpace === 'function';
let shapes = null;  // of the parts, once they are read
const kinds = data.shapes?.note || problem.parts.some(([, , , , product]) => product) ? kindsOf(problem) : null;
const several = plans.length > 1;
const position = new Position(plans, problem.direction);

startTheme();

const section = (name, title, ...children) => h('section', {id: name, 'aria-labelledby': `${name}-title`}, h('h2', {id: `${name}-title`}, title), children);
/** What stands for a drawing on paper, where a canvas would be cut: `pictures()` gives addresses of images. */
function printed(pictures) {
  const box = h('div', {class: 'printed', 'aria-hidden': 'true'});
  onPrint(() => fill(box, pictures().map((src) => h('img', {src, alt: '', decoding: 'sync'}))));
  return box;
}

/** A table that scrolls in its own frame where it does not fit; `long` ones in height too. */
const scroller = (label, long, ...children) => h('div', {class: long ? 'scroller long' : 'scroller', tabindex: 0, role: 'region', 'aria-label': label, 'data-scrolls': ''}, children);

// ---------------------------------------------------------------------------------------------------------------------
// Head

function themeButton() {
  const button = h('button', {type: 'button', class: 'theme', onclick: toggleTheme});
  const update = () => (button.textContent = isDark() ? 'Light' : 'Dark');
  button.setAttribute('aria-label', 'Switch between light and dark');
  onTheme(update);
  update();
  return button;
}

function fact(name, ...value) {
  return h('div', {class: 'fact'}, h('dt', {}, name), h('dd', {}, value));
}

function head() {
  const [plan] = plans;
  const status = plans.length === 1 ? plan.status : best.status;
  const facts = [];
  if (plans.length === 1) {
    facts.push(fact('Status', h('span', {class: `status ${status.replace(' ', '-')}`}, status)));
    facts.push(fact(plan.expected ? 'Expected reward' : 'Reward', number(plan.reward)));
  } else if (plans.length === 0) {
    facts.push(fact('Status', h('span', {class: `status ${status}`}, status)));
  }
  facts.push(fact('Bound', number(best.bound)));
  if (plans.length === 1) facts.push(fact('Gap', number(plan.gap)));
  if (data.fleet && plans.length === 1) facts.push(fact('Steps', grouped(plan.makespan)), fact('Travel, m²', number(plan.travel)));
  if (data.fleet) facts.push(fact('Robots', grouped(data.fleet.robots)));
  facts.push(fact('Parts', grouped(problem.parts.length)), fact('Connections', grouped(problem.connections.length)));
  const kind = problem.direction === 'assembly' ? 'Planned as assembly' : 'Planned as disassembly';
  return h('header', {},
    h('div', {class: 'bar'}, h('span', {class: 'brand'}, 'orasp report'), themeButton()),
    h('h1', {}, data.title),
    h('p', {class: 'lead'}, plans.length === 1 ? plan.verdict : best.sentence),
    h('dl', {class: 'facts'}, facts),
    h('p', {class: 'quiet'}, `${kind}. Objective: ${problem.objective[1]}.`));
}

// ---------------------------------------------------------------------------------------------------------------------
// Stage: the assembly and the step, a column for each plan

const places = layOut(problem);

const stepSentence = (plan) => {
  const step = position.step(plan);
  const {place, order} = position;
  if (!step) return order === 'disassembly' ? 'Start: the whole product' : 'Start: all parts apart';
  const name = cutOf(step).map((c) => problem.connections[c][0]).join(', ');
  const moved = step.moved ? `${step.moved.length === 1 ? `${problem.parts[step.moved[0]][0]} ` : `${step.moved.length} parts `}${order === 'disassembly' ? 'come off' : 'come on'}` : 'nothing moves';
  return `Step ${Math.min(place, plan.steps.length)} of ${plan.steps.length}: ${act(order)} ${name}, ${moved.replace(/^(\S+) come (o)/, (all, part, o) => (step.moved?.length === 1 ? `${part} comes ${o}` : all))}`;
};

/** A move of robots in words. */
function moveWords({robots, parts: moved, from, to, motion}, order) {
  const {places: names} = data.fleet;
  const [begin, end, along] = order === 'disassembly' ? [from, to, motion[0]] : [to, from, motion[1]];
  const way = begin === end ? `within ${names[begin]}` : `from ${names[begin]} to ${names[end]}`;
  return [`${robots.length === 1 ? 'Robot' : 'Robots'} ${robots.join(', ')}: `, partList(problem, moved), ` ${way}${along === 'stay' ? '' : ` along ${along}`}`];
}

/** What a step earns and what was earned with it, in the order shown. */
const totalOf = (step) => (position.order === problem.direction ? step.total : step.back);

class PlanView {
  constructor(plan, number_) {
    this.plan = plan;
    this.replay = new Replay(problem, plan);
    this.canvas = h('div', {class: 'canvas'});
    this.space = h('div', {class: 'canvas space', hidden: true});
    this.frame = h('div', {class: 'frame', role: 'img'}, this.canvas, this.space);
    this.card = h('div', {class: 'card'});
    const tool = (label, text, action) => h('button', {type: 'button', class: 'tool', 'aria-label': label, title: label, onclick: action}, text);
    this.own = h('div', {class: 'own-tools'});
    this.tools = h('div', {class: 'tools', role: 'group', 'aria-label': `Drawing${several ? ` of ${plan.label}` : ''}`}, this.own,
      tool('Zoom in', '+', () => this.drawing.zoom(1.25)), tool('Zoom out', '−', () => this.drawing.zoom(0.8)), tool('Fit to the frame', 'Fit', () => this.drawing.fit()));
    const title = several ? h('h3', {}, id(plan.label), ' ', h('span', {class: `status ${plan.status.replace(' ', '-')}`}, plan.status)) : null;
    this.element = h('div', {class: 'plan', 'data-plan': number_}, title, h('div', {class: 'stage'}, this.tools, this.frame, printed(() => [...(this.inSpace ? [this.inSpace.picture()] : []), this.printedGraph()])), this.card);
  }

  /** Once it stands in the page. */
  start() {
    this.graph = new AssemblyGraph(this.canvas, problem, places);
    this.drawing = this.graph;
    if (shapes || placed) this.startSpace();
    new ResizeObserver(() => this.drawing.resize()).observe(this.frame);
    this.update();
  }

  startSpace() {
    try {
      this.space.hidden = false;
      const theme = {colours, onTheme, pieceColour};
      this.inSpace = shapes ? globalThis.oraspShapes.view(this.space, problem, this.plan, shapes, theme) : globalThis.oraspSpace(this.space, problem, theme);
    } catch {
      this.space.hidden = true;  // no WebGL here: the graph shows the same
      return;
    }
    const choice = (name, on) => h('button', {type: 'button', class: 'tool', 'aria-pressed': String(on), onclick: () => this.choose(name)}, name);
    this.choices = [choice('3-D', true), choice('Graph', false)];
    this.tools.prepend(...this.choices);
    if (shapes) this.startShapes();
    this.choose('3-D');
  }
  /** The slider that takes the product apart, labels, and the book. */
  startShapes() {
    const {inSpace, plan} = this;
    const n = inSpace.moves.length;
    const slider = h('input', {
      type: 'range', class: 'apart', min: 0, max: 1000, step: 1, value: 0, 'aria-label': 'Taken apart',
      oninput: () => {
        inSpace.explode(Number(slider.value) / 1000);
        told();
      },
    });
    const told = () => slider.setAttribute('aria-valuetext', `${inSpace.exploded[0]} of ${counted(n, 'piece')} out`);
    told();
    const labels = h('button', {
      type: 'button', class: 'tool', 'aria-pressed': 'false',
      onclick: () => {
        inSpace.setLabels(!inSpace.labelled);
        labels.setAttribute('aria-pressed', String(inSpace.labelled));
      },
    }, 'Labels');
    this.own.append(labels);
    if (n === 0) return;
    this.own.append(h('label', {class: 'apart-name'}, 'Apart ', slider));
    this.book = new Book(problem, plan, inSpace, several ? `${data.title}: ${plan.label}` : data.title);
    const book = h('button', {type: 'button', class: 'tool', onclick: () => this.book.open(book)}, 'Book');
    this.own.append(book);
    document.getElementById('page').append(this.book.element);
  }
  choose(name) {
    const space = name === '3-D';
    this.canvas.hidden = space;
    this.space.hidden = !space;
    this.own.hidden = !space;
    this.drawing = space ? this.inSpace : this.graph;
    for (const button of this.choices) button.setAttribute('aria-pressed', String((button.textContent === '3-D') === space));
    this.drawing.resize();
    if (!space) this.graph.show(this.replay, position.step(this.plan));
    else this.inSpace.show(this.replay, position.step(this.plan), position.order, false);
  }

  printedGraph() {
    this.graph.show(this.replay, position.step(this.plan));
    return this.graph.picture();
  }

  update() {
    const {plan, replay} = this;
    const step = position.step(plan);
    replay.goTo(position.removals(plan));
    if (this.drawing === this.graph) this.graph.show(replay, step);
    else this.inSpace.show(replay, step, position.order);
    const [pieces, subassemblies] = plan.states[replay.removed];
    this.frame.setAttribute('aria-label', `${this.drawing === this.graph ? 'The assembly as a graph' : shapes ? 'The true parts in space' : 'The assembly in space'}: ${counted(pieces, 'piece')}, ${subassemblies} of them with two or more parts. The text beside it says the same in words.`);
    fill(this.card, this.stepCard(step), this.pieceCard(pieces, subassemblies));
  }

  stepCard(step) {
    const {plan} = this;
    const {order, place} = position;
    const title = step
      ? [`Step ${Math.min(place, plan.steps.length)} of ${plan.steps.length}: ${act(order)} `, cutList(problem, step)]
      : [order === 'disassembly' ? 'Start: the whole product' : 'Start: all parts apart'];
    const tag = several ? 'h4' : 'h3';
    if (!step) return h('div', {class: 'step'}, h(tag, {class: 'step-title'}, title), h('p', {}, place === 0 && plan.steps.length > 0 ? `${counted(plan.steps.length, 'step')} to come. Use the arrow keys, the slider or Play.` : 'There is no step.'));
    return h('div', {class: 'step'},
      h(tag, {class: 'step-title'}, title),
      h('dl', {class: 'pairs'},
        step.moves
          ? [h('dt', {}, 'Moves'), h('dd', {}, h('ul', {class: 'moves'}, step.moves.map((move) => h('li', {}, moveWords(move, order)))))]
          : [h('dt', {}, order === 'disassembly' ? 'Comes off' : 'Comes on'), h('dd', {}, movement(problem, step))],
        step.way ? [h('dt', {}, 'Along'), h('dd', {}, id(wayOf(step, order)))] : [],
        this.operation(step),
        h('dt', {}, 'Earns'), h('dd', {class: 'num'}, number(step.reward)),
        h('dt', {}, 'Total'), h('dd', {class: 'num'}, number(totalOf(step)))),
      h('h5', {class: 'small'}, step.broken ? 'Not allowed' : 'Allowed because'),
      reasonList(step, order));
  }

  /** The steps that are done in one go with this one, where they are several. */
  operation(step) {
    const {plan} = this;
    const {order} = position;
    const {operations = []} = plan;
    const at = plan.steps.indexOf(step);
    const i = operations.findIndex(([first, end]) => first <= at && at < end);
    if (i < 0 || operations[i][1] - operations[i][0] < 2) return [];
    const number = order === 'disassembly' ? i + 1 : operations.length - i;
    return [h('dt', {}, 'In one go'), h('dd', {class: 'operation'}, `${number} of ${operations.length}: `, operationWords(problem, plan, operations[i], order))];
  }

  pieceCard(pieces, subassemblies) {
    const all = this.replay.pieces();
    // Where shapes or products are known, equal parts are counted.
    const named = (parts) => (kinds ? byKind(kinds, parts).slice(0, 15).flatMap((kind, i) => [i > 0 ? ', ' : '', i < 14 ? id(kindText(kind)) : 'and more']) : partList(problem, parts, 14));
    const big = all.filter(({parts}) => parts.length > 1);
    const single = all.filter(({parts}) => parts.length === 1).map(({parts}) => parts[0]);
    const items = big.slice(0, 8).map(({label, parts}) => h('li', {}, h('span', {class: 'swatch', style: `background:${pieceColour(colours(), label)}`}), h('span', {}, h('b', {}, counted(parts.length, 'part')), ' ', named(parts))));
    if (big.length > 8) items.push(h('li', {}, `and ${big.length - 8} more pieces of two or more parts`));
    if (single.length > 0) items.push(h('li', {}, h('span', {class: 'swatch single'}), h('span', {}, h('b', {}, counted(single.length, 'single part')), ' ', named(single))));
    return h('div', {class: 'pieces', 'data-pieces': pieces, 'data-subassemblies': subassemblies},
      h('h5', {class: 'small'}, `Pieces now: ${grouped(pieces)}`),
      h('ul', {}, items));
  }
}

const views = plans.map((plan, i) => new PlanView(plan, i));
const live = h('p', {class: 'unseen', 'aria-live': 'polite'});

function stage() {
  if (plans.length === 0) {
    const replay = new Replay(problem, {steps: [], labels: problem.parts.map(() => 0), states: []});
    replay.removal = problem.connections.map(() => Infinity);
    const canvas = h('div', {class: 'canvas'});
    const element = section('assembly', 'Assembly', h('div', {class: 'stage'}, h('div', {class: 'frame', role: 'img', 'aria-label': 'The assembly as a graph'}, canvas)));
    return {element, start: () => new AssemblyGraph(canvas, problem, places).show(replay)};
  }
  const player = new Player(position, () => stepSentence(plans[0]));
  const note = data.shapes?.fault ? h('p', {class: 'fault'}, data.shapes.fault) : null;
  const element = section('plan', several ? 'The plans, step by step' : 'The plan, step by step',
    h('div', {class: several ? 'plans several' : 'plans'}, views.map((view) => view.element)), note, player.element, live);
  const start = () => {
    for (const view of views) view.start();
    let last = '';
    position.onChange(() => {
      for (const view of views) view.update();
      const text = stepSentence(plans[0]);
      // While it plays fast, a reader could not keep up.
      if (!player.playing || player.pause() >= 1000) live.textContent = text;
      else if (last !== '') last = text;
    });
  };
  return {element, start, player};
}

// ---------------------------------------------------------------------------------------------------------------------
// Chart of the running reward

function rewardChart() {
  if (plans.every((plan) => plan.steps.length === 0)) return null;
  const box = h('div', {class: 'chart'});
  const points = (plan) => {
    const list = [[0, 0]];
    for (let place = 1; place <= plan.steps.length; ++place) list.push([place, totalOf(plan.steps[index(plan, place, position.order)])]);
    return list;
  };
  const comparable = best.bound !== null && plans.some((plan) => plan.gap !== null);
  const caption = `Reward so far, after each step${comparable ? `; no plan ends above the bound, ${number(best.bound)}` : ''}.`;
  const element = section('reward', 'Running reward', h('figure', {}, box, h('figcaption', {}, several ? lineKey(plans.map(({label}) => label)) : null, caption)));
  const start = () => {
    const chart = lineChart(box, {
      series: () => plans.map((plan) => ({name: several ? plan.label : '', points: points(plan), step: true})),
      levels: () => (comparable ? [{name: `bound ${number(best.bound)}`, y: best.bound}] : []),
      xTitle: 'step', yTitle: 'reward so far',
      label: () => `${caption} ${plans.map((plan) => `${plan.label} ends at ${number(plan.steps.length > 0 ? totalOf(plan.steps[index(plan, plan.steps.length, position.order)]) : 0)}`).join('; ')}.`,
    });
    const mark = () => chart.mark(plans.map((plan) => {
      const place = Math.min(position.place, plan.steps.length);
      return [place, place === 0 ? 0 : totalOf(position.step(plan))];
    }));
    let {order} = position;
    position.onChange(() => {
      if (order !== position.order) {
        ({order} = position);
        chart.redraw();
      }
      mark();
    });
    new ResizeObserver(mark).observe(box);
    mark();
  };
  return {element, start};
}

// ---------------------------------------------------------------------------------------------------------------------
// Tables

function stepTable(plan) {
  const body = h('tbody', {});
  const rows = [];
  const build = () => {
    const {order} = position;
    const inOrder = plan.steps.map((_, i) => plan.steps[index(plan, i + 1, order)]);
    const rewards = column(inOrder.map((step) => step.reward));
    const totals = column(inOrder.map(totalOf));
    rows.length = 0;
    inOrder.forEach((step, i) => {
      const removals = order === 'disassembly' ? i + 1 : plan.steps.length - i - 1;
      const go = h('button', {type: 'button', class: 'row', 'aria-label': `Go to step ${i + 1}`, onclick: () => position.set(i + 1)}, String(i + 1));
      rows.push(h('tr', {class: step.broken ? 'broken' : null},
        h('td', {class: 'num'}, go), h('td', {}, cutList(problem, step)), h('td', {}, step.moved ? partList(problem, step.moved, 8) : '–'),
        h('td', {class: 'num'}, rewards[i]), h('td', {class: 'num'}, totals[i]), h('td', {class: 'num'}, String(plan.states[removals][0])), h('td', {class: 'why'}, reasonList(step, order))));
    });
    fill(body, rows);
    mark();
  };
  let current = null;
  const mark = () => {
    current?.removeAttribute('aria-current');
    current = rows[Math.min(position.place, plan.steps.length) - 1] ?? null;
    current?.setAttribute('aria-current', 'step');
  };
  let {order} = position;
  position.onChange(() => {
    if (order === position.order) return mark();
    ({order} = position);
    return build();
  });
  build();
  const columns = ['Step', 'Connection', 'Moves', 'Earns', 'Total', 'Pieces', 'Allowed because'];
  const numeric = new Set(['Step', 'Earns', 'Total', 'Pieces']);
  return scroller(`Steps of ${plan.label}`, plan.steps.length > 40, h('table', {class: 'steps'}, h('caption', {class: 'unseen'}, `Steps of ${plan.label}`),
    h('thead', {}, h('tr', {}, columns.map((name) => h('th', {scope: 'col', class: numeric.has(name) ? 'num' : null}, name)))), body));
}

function steps() {
  if (plans.length === 0) return null;
  return section('steps', 'All steps', plans.map((plan) => [
    several ? h('h3', {}, id(plan.label)) : null,
    plan.violations.length > 0 ? violationList(plan) : null,
    plan.steps.length > 0 ? stepTable(plan) : h('p', {}, 'The plan has no step.'),
  ]));
}

function violationList(plan) {
  return h('div', {class: 'violations'}, h('h4', {}, `${counted(plan.violations.length, 'violation')}`),
    h('ul', {}, plan.violations.slice(0, 50).map(([step, connection, constraint, message]) => h('li', {}, step > 0 ? [`Step ${step}`, connection ? [', ', id(connection)] : '', ': '] : '', h('b', {}, constraintName(constraint)), ' ', message)),
      plan.violations.length > 50 ? h('li', {}, `and ${plan.violations.length - 50} more`) : null));
}

function comparison() {
  if (!several) return null;
  const rewards = column(plans.map((plan) => plan.reward));
  const body = plans.map((plan, i) => h('tr', {}, h('th', {scope: 'row'}, id(plan.label)), h('td', {}, h('span', {class: `status ${plan.status.replace(' ', '-')}`}, plan.status)), h('td', {class: 'num'}, rewards[i]), h('td', {class: 'num'}, number(plan.gap)), h('td', {class: 'num'}, String(plan.steps.length)), h('td', {class: 'num'}, String(plan.violations.length)), h('td', {}, plan.verdict)));
  return section('comparison', 'The plans compared', scroller('The plans compared', false, h('table', {},
    h('thead', {}, h('tr', {}, ['Plan', 'Status'].map((name) => h('th', {scope: 'col'}, name)), ['Reward', 'Gap', 'Steps', 'Broken rules'].map((name) => h('th', {scope: 'col', class: 'num'}, name)), h('th', {scope: 'col'}, 'What is proved'))),
    h('tbody', {}, body))));
}

// ---------------------------------------------------------------------------------------------------------------------
// A fleet: a lane for each robot and each place, a column for each step

function laneTable(plan) {
  const {robots, places: names} = data.fleet;
  const table = h('table', {class: 'lanes'});
  let columns = [];
  const build = () => {
    const {order} = position;
    const n = plan.steps.length;
    const inOrder = plan.steps.map((_, i) => plan.steps[index(plan, i + 1, order)]);
    columns = inOrder.map(() => []);
    const cell = (i, tag, attributes, ...children) => {
      const element = h(tag, attributes, children);
      columns[i].push(element);
      return element;
    };
    const head = h('tr', {}, h('th', {scope: 'col'}, 'Lane'), inOrder.map((_, i) => cell(i, 'th', {scope: 'col'}, h('button', {type: 'button', class: 'row', 'aria-label': `Go to step ${i + 1}`, onclick: () => position.set(i + 1)}, String(i + 1)))));
    const robotRows = [...Array(robots).keys()].map((r) => h('tr', {}, h('th', {scope: 'row'}, `Robot ${r + 1}`), inOrder.map((step, i) => {
      const move = step.moves.find(({robots: busy}) => busy.includes(r + 1));
      if (!move) return cell(i, 'td', {class: 'idle'}, '–');
      const part = move.parts[move.robots.indexOf(r + 1)];
      const [from, to, along] = order === 'disassembly' ? [move.from, move.to, move.motion[0]] : [move.to, move.from, move.motion[1]];
      return cell(i, 'td', {class: 'busy'}, id(problem.parts[part][0]), h('small', {}, from === to ? ` in ${names[from]}` : ` ${names[from]} → ${names[to]}`, along === 'stay' ? '' : `, ${along}`));
    })));
    const placeRows = names.map((name, at) => h('tr', {class: at === 0 ? 'first-place' : null}, h('th', {scope: 'row'}, name), inOrder.map((_, i) => {
      const {places: where} = plan.world[order === 'disassembly' ? i + 1 : n - i - 1];
      const there = where.map((place, part) => (place === at ? part : -1)).filter((part) => part >= 0);
      return cell(i, 'td', {class: there.length > 0 ? null : 'idle'}, there.length > 0 ? partList(problem, there, 6) : '–');
    })));
    fill(table, h('caption', {class: 'unseen'}, `What each robot does and what stands where, ${plan.label}`), h('thead', {}, head), h('tbody', {}, robotRows, placeRows));
    mark();
  };
  const mark = () => columns.forEach((cells, i) => {
    for (const element of cells) element.classList.toggle('here', i + 1 === Math.min(position.place, plan.steps.length));
  });
  let {order} = position;
  position.onChange(() => {
    if (order === position.order) return mark();
    ({order} = position);
    return build();
  });
  build();
  return scroller(`Robots and places of ${plan.label}`, false, table);
}

function lanes() {
  if (!data.fleet || plans.length === 0) return null;
  return {
    element: section('lanes', 'Robots and places', h('p', {class: 'quiet'}, 'Each column is a step: above, the part that a robot moves; below, what stands in a place afterwards.'),
      plans.map((plan) => [several ? h('h3', {}, id(plan.label)) : null, laneTable(plan)])),
    start: () => {},
  };
}

function constraints() {
  const list = problem.constraints;
  if (list.length === 0) return section('constraints', 'Constraints', h('p', {}, 'None: any connection may go at any time.'));
  const rows = list.map(([kind, where, text]) => h('tr', {}, h('td', {class: 'bare'}, constraintName(kind)), h('td', {}, text), h('td', {class: 'quiet bare'}, where)));
  return section('constraints', 'Constraints', h('p', {class: 'quiet'}, 'Said for taking apart; putting together reverses them.'),
    scroller('Constraints', list.length > 12, h('table', {}, h('thead', {}, h('tr', {}, h('th', {scope: 'col'}, 'Kind'), h('th', {scope: 'col'}, 'Rule'), h('th', {scope: 'col'}, 'In the file'))), h('tbody', {}, rows))));
}

// ---------------------------------------------------------------------------------------------------------------------
// H

function stateGraph() {
  const {graph} = data;
  if (!graph) return null;
  const [states, actions] = graph.size;
  const sentences = [`The state-action graph H holds ${counted(states, 'state')} and ${counted(actions, 'action')}.`];
  if (graph.free) {
    const [freeStates, freeActions] = graph.free;
    sentences.push(`Without precedence it would hold ${counted(freeStates, 'state')} and ${counted(freeActions, 'action')}: precedence prunes ${counted(freeStates - states, 'state')} and ${counted(freeActions - actions, 'action')}.`);
  }
  const {drawing} = graph;
  if (!drawing) return {element: section('states', 'State-action graph H', h('p', {}, sentences.join(' '), ' It is too large to be drawn here.')), start: () => {}};
  const canvas = h('div', {class: 'canvas'});
  const said = h('p', {class: 'said'}, 'Point at a state to read it.');
  let view = null;
  const tool = (label, text, action) => h('button', {type: 'button', class: 'tool', 'aria-label': label, title: label, onclick: action}, text);
  const prunes = drawing.nodes.some(([, , kind]) => kind === 1) || drawing.actions.some((action) => action[4] === 1);
  const key = [
    h('li', {}, h('span', {class: 'swatch', style: 'background:var(--piece-0)'}), 'state'),
    plans.length > 0 ? h('li', {}, h('span', {class: 'swatch', style: 'background:var(--accent)'}), several ? 'on the way of a plan' : `on the way of the ${plans[0].status === 'optimal' ? 'optimal ' : ''}plan`) : null,
    prunes ? h('li', {}, h('span', {class: 'swatch pruned'}), 'pruned by a precedence') : null,
    drawing.nodes.some(([, , kind]) => kind === 2) ? h('li', {}, h('span', {class: 'swatch dead'}), 'dead end') : null,
  ];
  const element = section('states', 'State-action graph H',
    h('p', {}, sentences.join(' '), ' Top: ', problem.direction === 'assembly' ? 'nothing connected' : 'everything connected', '; each layer has handled one connection more.'),
    h('figure', {}, h('div', {class: 'stage'},
      h('div', {class: 'tools', role: 'group', 'aria-label': 'Drawing of H'}, tool('Zoom in', '+', () => view?.zoom(1.25)), tool('Zoom out', '−', () => view?.zoom(0.8)), tool('Fit to the frame', 'Fit', () => view?.fit())),
      h('div', {class: 'frame wide', role: 'img', 'aria-label': `H with ${counted(states, 'state')}; the plan's way through it is marked. The table of all steps says the way in words.`}, canvas),
      printed(() => {
        make();
        return [view.picture()];
      })),
    h('figcaption', {}, h('ul', {class: 'key'}, key), said)));
  const mark = () => {
    if (!view) return;
    // Paths run in the problem's direction.
    view.mark(plans.map((plan, i) => {
      const done = position.removals(plan);
      return drawing.paths[i][problem.direction === 'assembly' ? plan.steps.length - done : done];
    }).filter((node) => node !== undefined));
  };
  // Laid out when it comes into sight, or is printed: it takes a moment.
  const make = () => {
    if (view) return;
    view = new StateGraph(canvas, drawing, (node) => (said.textContent = node === null ? '' : stateWords(problem, drawing, node)));
    mark();
    new ResizeObserver(() => view.resize()).observe(canvas);
  };
  const start = () => {
    const seen = new IntersectionObserver((entries) => {
      if (!entries.some((entry) => entry.isIntersecting)) return;
      seen.disconnect();
      make();
    }, {rootMargin: '200px'});
    seen.observe(canvas);
    position.onChange(mark);
  };
  return {element, start};
}

// ---------------------------------------------------------------------------------------------------------------------
// Learning and the distribution

function learning() {
  if (!data.learning) return null;
  const {points, rounds} = data.learning;
  const box = h('div', {class: 'chart'});
  const series = [['network now', 1], ['best network', 2], ['best plan met', 3]].map(([name, at], i) => ({name, kind: i, points: points.map((point) => [point[0], point[at]])}));
  const bound = points.at(-1)[4] ?? best.bound;
  const last = points.at(-1);
  const caption = `Learning curve over ${counted(rounds, 'round')}: at the end the network earns ${number(last[1])}, at best ${number(last[2])}; the best plan met earns ${number(last[3])}.`;
  return {
    element: section('learning', 'Learning', h('figure', {}, box, h('figcaption', {}, lineKey(series.map(({name}) => name)), caption))),
    start: () => lineChart(box, {series: () => series, levels: () => (bound === null ? [] : [{name: `bound ${number(bound)}`, y: bound}]), xTitle: 'episodes', yTitle: 'reward', label: () => caption}),
  };
}

function distribution() {
  const {sample} = data;
  if (!sample) return null;
  const box = h('div', {class: 'chart'});
  const marks = plans.filter((plan) => plan.reward !== null && plan.valid).map((plan) => ({name: `${several ? plan.label : 'this plan'} ${number(plan.reward)}`, value: plan.reward, kind: 'plan'}));
  if (best.bound !== null) marks.push({name: `${best.status === 'optimal' ? 'optimum' : 'bound'} ${number(best.bound)}`, value: best.bound, kind: 'bound'});
  const caption = `${sample.origin} Half of them lie between ${number(sample.quartiles[0])} and ${number(sample.quartiles[2])}.`;
  const figures = [['Mean', sample.mean], ['Deviation', sample.deviation], ['Least', sample.min], ['Lower quartile', sample.quartiles[0]], ['Median', sample.quartiles[1]], ['Upper quartile', sample.quartiles[2]], ['Greatest', sample.max]];
  return {
    element: section('distribution', 'Random sequences', h('figure', {}, box, h('figcaption', {}, caption)), h('dl', {class: 'facts'}, figures.map(([name, value]) => fact(name, number(value))))),
    start: () => violin(box, {sample, marks, label: () => `Distribution of the rewards. ${caption} ${marks.map(({name}) => name).join('; ')}.`}),
  };
}

// ---------------------------------------------------------------------------------------------------------------------
// What is proved and where it comes from

function about() {
  const paragraphs = [h('p', {}, best.sentence)];
  for (const plan of plans) paragraphs.push(h('p', {}, several ? [id(plan.label), ': '] : '', `${plan.origin} ${plan.verdict}`, plan.notes.map((note) => ` ${note}`)));
  if (data.shapes?.note) paragraphs.push(h('p', {}, data.shapes.note));
  if (best.conflict.length > 0) paragraphs.push(h('p', {}, 'These rules allow no plan together:'), h('ul', {}, best.conflict.map((text) => h('li', {}, text))));
  const details = [
    ['Method', best.method], ['Effort', best.effort], ['Objective', problem.objective[0]], ['Digest', problem.digest], ['Source', problem.source], ['Note', problem.note],
  ].filter(([, value]) => value);
  return section('about', 'What is proved, and how',
    paragraphs, best.notes.length > 0 ? h('ul', {}, best.notes.map((note) => h('li', {}, note))) : null,
    h('dl', {class: 'pairs wide'}, details.map(([name, value]) => [h('dt', {}, name), h('dd', {}, value)])));
}

function parts() {
  const named = problem.parts.some(([ident, name, mass]) => (name && name !== ident) || mass !== 1);
  if (!named) return null;
  const rows = problem.parts.map(([ident, name, mass]) => h('tr', {}, h('td', {}, id(ident)), h('td', {}, id(name)), h('td', {class: 'num'}, number(mass))));
  return section('parts', 'Parts', scroller('Parts', rows.length > 40, h('table', {}, h('thead', {}, h('tr', {}, h('th', {scope: 'col'}, 'Part'), h('th', {scope: 'col'}, 'Name'), h('th', {scope: 'col', class: 'num'}, 'Mass, kg'))), h('tbody', {}, rows))));
}

// ---------------------------------------------------------------------------------------------------------------------

const stages = [stage(), lanes(), rewardChart(), stateGraph(), learning(), distribution()].filter(Boolean);
const [main] = stages;
const figure = (name) => stages.find(({element}) => element.id === name)?.element;
const page = document.getElementById('page');
fill(page,
  h('a', {class: 'skip', href: `#${main.element.id}`}, 'To the plan'),
  head(),
  h('main', {}, comparison(), main.element, figure('lanes'), h('div', {class: 'pair'}, figure('reward'), constraints()), figure('states'), figure('learning'), figure('distribution'), steps(), about(), parts()),
  h('footer', {}, `Written by orasp ${data.version}. This file needs no network.`));
/** The shapes of the parts, which stand in the page as a file; null where there are none, or nothing to draw them. */
async function read() {
  const file = document.getElementById('shapes');
  if (!file) return null;
  try {
    return await globalThis.oraspShapes.readShapes(file.textContent, problem.parts.length);
  } catch {
    return null;
  }
}

read().then((found) => {
  shapes = found;
  for (const {start} of stages) start();
  document.documentElement.dataset.ready = 'true';
});

// For tests and for the console: where the page stands.
globalThis.orasp = {data, position, player: main.player, views, partName};
