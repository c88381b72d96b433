// A plan as it stands after any number of its steps. The page works nothing out about assemblies: each removal in the data
// says which parts take which new label, and this applies the removals, or takes them back.

/** The connections that a step removes: one, or of a fleet several. */
export const cutOf = (step) => step.cut ?? [step.c];

export class Replay {
  /** `plan` of the data; `problem` for its direction and its numbers of parts and connections. */
  constructor(problem, plan) {
    this.plan = plan;
    this.steps = plan.steps;
    this.labels = plan.labels.slice();
    this.removed = 0;
    // The removal (from 1) at which a connection goes; what the plan does not handle stays, or in assembly is never there.
    const never = problem.direction === 'assembly' ? 0 : Infinity;
    this.removal = problem.connections.map(() => never);
    this.steps.forEach((step, k) => {
      for (const c of cutOf(step)) this.removal[c] = k + 1;
    });
  }

  /** Goes to the state after `k` removals. */
  goTo(k) {
    if (this.plan.world) {
      this.labels = this.plan.world[k].labels;
      this.removed = k;
    }
    while (this.removed < k) {
      const {moved = [], split, rest = []} = this.steps[this.removed++];
      for (const part of moved) this.labels[part] = split[1];
      for (const [label, parts] of rest) for (const part of parts) this.labels[part] = label;
    }
    while (this.removed > k) {
      const {moved = [], split, rest = []} = this.steps[--this.removed];
      for (const part of moved) this.labels[part] = split[0];
      for (const [, parts] of rest) for (const part of parts) this.labels[part] = split[0];
    }
  }

  present(connection) {
    return this.removal[connection] > this.removed;
  }

  /** The pieces: lists of parts, the largest first. */
  pieces() {
    const byLabel = new Map();
    this.labels.forEach((label, part) => {
      if (!byLabel.has(label)) byLabel.set(label, []);
      byLabel.get(label).push(part);
    });
    return [...byLabel].map(([label, parts]) => ({label, parts})).sort((a, b) => b.parts.length - a.parts.length || a.parts[0] - b.parts[0]);
  }
}

/** Where the page stands: a place in the order that is shown. */
export class Position {
  constructor(plans, order) {
    this.length = Math.max(0, ...plans.map((plan) => plan.steps.length));
    this.order = order;
    this.place = 0;
    this.listeners = [];
  }
  onChange(listener) {
    this.listeners.push(listener);
  }
  set(place, order = this.order) {
    const wanted = Math.min(Math.max(place, 0), this.length);
    if (wanted === this.place && order === this.order) return;
    this.place = wanted;
    this.order = order;
    for (const listener of this.listeners) listener();
  }
  /** Removals done in `plan` here. */
  removals(plan) {
    const place = Math.min(this.place, plan.steps.length);
    return this.order === 'disassembly' ? place : plan.steps.length - place;
  }
  /** The step that led here, as in the data; undefined at the beginning. */
  step(plan) {
    const place = Math.min(this.place, plan.steps.length);
    return place === 0 ? undefined : plan.steps[index(plan, place, this.order)];
  }
}

/** The place in the data of the `place`-th step (from 1) in an order. */
export const index = (plan, place, order) => (order === 'disassembly' ? place - 1 : plan.steps.length - place);
