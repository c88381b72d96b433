// A step in words.
import {h, id} from './dom.js';
import {constraintName} from './format.js';
import {cutOf} from './replay.js';

export const partName = (problem, part) => {
  const [ident, name] = problem.parts[part];
  return name && name !== ident ? `${ident} (${name})` : ident;
};

/** Parts as a list of ids, cut after `most`; several of one product are counted: "3 × M5 nut". */
export function partList(problem, parts, most = 12) {
  const kinds = new Map();
  for (const part of parts) {
    const product = problem.parts[part][4];
    const key = product ? `of ${product}` : part;
    if (!kinds.has(key)) kinds.set(key, []);
    kinds.get(key).push(part);
  }
  const all = [...kinds.values()];
  const shown = all.slice(0, all.length > most + 1 ? most : all.length);
  const list = shown.flatMap((equal, i) => [i > 0 ? ', ' : '', id(equal.length > 1 ? `${equal.length} × ${problem.parts[equal[0]][4]}` : partName(problem, equal[0]))]);
  const left = all.slice(shown.length).reduce((sum, equal) => sum + equal.length, 0);
  if (left > 0) list.push(` and ${left} more`);
  return list;
}

/** "remove 1-2" or "connect 1-2". */
export const act = (order) => (order === 'disassembly' ? 'remove' : 'connect');

/** The ids of the connections that a step removes, as children of an element. */
export const cutList = (problem, step) => cutOf(step).flatMap((c, i) => [i > 0 ? ', ' : '', id(problem.connections[c][0])]);

/** What moves in a step, as children of an element. */
export const movement = (problem, step, most) => (step.moved ? partList(problem, step.moved, most) : ['nothing']);

/** The name of the direction in which the moved piece goes; only where the problem has blocking. */
export const wayOf = (step, order) => step.way[order === 'disassembly' ? 0 : 1];

/** What is done in one go: "undo a, b; c comes off along +y", as children of an element. `range` is one of plan.operations. */
export function operationWords(problem, plan, [first, end], order) {
  const off = order === 'disassembly';
  const steps = plan.steps.slice(first, end);
  const step = steps.find(({moved}) => moved);
  if (!off) steps.reverse();
  const cuts = [off ? 'undo ' : 'connect ', steps.flatMap((one, i) => [i > 0 ? ', ' : '', cutList(problem, one)])];
  if (!step) return cuts;
  const come = `${step.moved.length === 1 ? 'comes' : 'come'} ${off ? 'off' : 'on'}`;
  const movement = [partList(problem, step.moved), ` ${come}`, step.way ? [' along ', id(wayOf(step, order))] : []];
  return off ? [cuts, '; then ', movement] : [movement, '; then ', cuts];
}

/** What allows a step: [constraint, sentence]. */
export const reasons = (step, order) => step.why.map(([constraint, , removed, made]) => [constraint, order === 'assembly' ? (made ?? removed) : removed]);

/** The list of what allows a step, or breaks. */
export function reasonList(step, order) {
  const items = [
    ...(step.broken ?? []).map(([constraint, text]) => h('li', {class: 'broken'}, h('b', {}, `Broken: ${constraintName(constraint)}`), ' ', text)),
    ...reasons(step, order).map(([constraint, text]) => h('li', {}, h('b', {}, constraintName(constraint)), ' ', text)),
  ];
  return items.length > 0 ? h('ul', {class: 'reasons'}, items) : h('p', {class: 'reasons'}, 'Nothing constrains it.');
}
