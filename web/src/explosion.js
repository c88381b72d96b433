// How far each piece goes, so that it is clear of what it leaves. Works on boxes along the axes, one a part, and knows
// neither pictures nor pages.

/** The smallest box around boxes. */
export function around(boxes) {
  const box = {low: [Infinity, Infinity, Infinity], high: [-Infinity, -Infinity, -Infinity]};
  for (const {low, high} of boxes) {
    for (let k = 0; k < 3; ++k) {
      box.low[k] = Math.min(box.low[k], low[k]);
      box.high[k] = Math.max(box.high[k], high[k]);
    }
  }
  return box;
}

export const centre = ({low, high}) => low.map((x, k) => (x + high[k]) / 2);

const diagonal = ({low, high}) => Math.hypot(...high.map((x, k) => x - low[k]));

const moved = ({low, high}, vector) => ({low: low.map((x, k) => x + vector[k]), high: high.map((x, k) => x + vector[k])});

const scaled = (vector, length) => vector.map((x) => x * length);

const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];

function unit(vector) {
  const length = Math.hypot(...vector);
  return length > 0 ? vector.map((x) => x / length) : [0, 0, 1];
}

/** The box seen along an axis: [least, greatest]. */
function shadow({low, high}, axis) {
  let [least, greatest] = [0, 0];
  for (let k = 0; k < 3; ++k) {
    least += axis[k] > 0 ? axis[k] * low[k] : axis[k] * high[k];
    greatest += axis[k] > 0 ? axis[k] * high[k] : axis[k] * low[k];
  }
  return [least, greatest];
}

/** How far `movers` must go along `direction` so that none of them is beside or behind what it could meet of `others`. */
export function clearance(movers, others, direction) {
  const aside = unit(cross(direction, Math.abs(direction[2]) < 0.9 ? [0, 0, 1] : [1, 0, 0]));
  const axes = [direction, aside, cross(direction, aside)];
  const seen = (box) => axes.map((axis) => shadow(box, axis));
  const still = others.map(seen);
  let distance = 0;
  for (const mover of movers.map(seen)) {
    for (const other of still) {
      const slack = 1e-6 * (mover[1][1] - mover[1][0] + mover[2][1] - mover[2][0]);
      const meets = [1, 2].every((k) => mover[k][0] < other[k][1] - slack && mover[k][1] > other[k][0] + slack);
      if (meets) distance = Math.max(distance, other[0][1] - mover[0][0]);
    }
  }
  return distance;
}

/** How far `movers` must go along `direction` to be beyond all of `others`, met or not: then nothing hides them. */
function beyond(movers, others, direction) {
  return Math.max(...others.map((box) => shadow(box, direction)[1])) - Math.min(...movers.map((box) => shadow(box, direction)[0]));
}

/** The direction in which the piece of a step leaves: the plan's, or where it has none away from what stays. */
function directionOf(step, movers, others) {
  if (step.way) return unit(step.way[2]);
  const from = centre(around(others));
  return unit(centre(around(movers)).map((x, k) => x - from[k]));
}

/**
 * For each step of a plan that moves something, in disassembly order: {step (its place), parts, direction, out, apart}.
 * Moved by `out`, the parts are beyond what stays of their piece. Moved by `apart`, in order and each after the one before
 * it, all parts end clear of each other, and none passes through another that was put there before: a piece goes beyond all
 * that what stays will reach on its own way, since what stays comes apart later.
 */
export function explode(plan, boxes) {
  // Wider between few pieces than between many.
  const count = Math.max(1, plan.steps.filter(({moved: parts}) => parts).length);
  const gap = Math.min(0.11, Math.max(0.03, 0.6 / count)) * diagonal(around(boxes));
  const labels = plan.labels.slice();
  const stays = plan.steps.map((step) => {
    if (!step.moved || !step.split) return null;
    const taken = new Set(step.moved);
    const rest = [];
    labels.forEach((label, part) => {
      if (label === step.split[0] && !taken.has(part)) rest.push(part);
    });
    for (const part of step.moved) labels[part] = step.split[1];
    for (const [label, parts] of step.rest ?? []) for (const part of parts) labels[part] = label;
    return rest;
  });
  // What each piece takes up, once it has come apart, and on the way there.
  const room = new Map();
  labels.forEach((label, part) => {
    if (!room.has(label)) room.set(label, []);
    room.get(label).push(boxes[part]);
  });
  const list = [];
  for (let k = plan.steps.length; k-- > 0;) {
    const step = plan.steps[k];
    if (!stays[k] || stays[k].length === 0) continue;
    const movers = step.moved.map((part) => boxes[part]);
    const others = stays[k].map((part) => boxes[part]);
    const direction = directionOf(step, movers, others);
    const [from, to] = step.split;
    const kept = [from, ...(step.rest ?? []).map(([label]) => label)].flatMap((label) => room.get(label));
    const going = room.get(to);
    const apart = clearance(going, kept, direction) + gap;
    const there = going.map((box) => moved(box, scaled(direction, apart)));
    const passed = movers.map((box) => around([box, moved(box, scaled(direction, apart))]));
    room.set(from, [...kept, ...there, ...passed]);
    list.push({step: k, parts: step.moved, direction, out: Math.max(0, beyond(movers, others, direction)) + 0.11 * diagonal(around([...movers, ...others])), apart});
  }
  return list.reverse();
}

/** Where each part is when `done` of the moves are done (the last one in part): how far from its place, as [x, y, z]. */
export function offsets(moves, count, done) {
  const list = Array.from({length: count}, () => [0, 0, 0]);
  moves.forEach(({parts, direction, apart}, i) => {
    const length = apart * Math.min(1, Math.max(0, done - i));
    if (length === 0) return;
    for (const part of parts) for (let k = 0; k < 3; ++k) list[part][k] += direction[k] * length;
  });
  return list;
}
