// The assembly as a graph: cytoscape draws it, fcose lays it out.
import cytoscape from 'cytoscape';
import fcose from 'cytoscape-fcose';
import {cutOf} from './replay.js';
import {colours, onTheme, pieceColour} from './theme.js';

cytoscape.use(fcose);

/** Runs `work` with Math.random replaced by numbers that are the same every time, so that a report looks the same each time. */
function repeatably(work) {
  const original = Math.random;
  let state = 1;
  Math.random = () => {
    state = (Math.imul(state, 1664525) + 1013904223) >>> 0;
    return state / 4294967296;
  };
  try {
    return work();
  } finally {
    Math.random = original;
  }
}

/** Where the parts lie, worked out once for all plans: a list of {x, y}. */
export function layOut(problem) {
  const sketch = cytoscape({headless: true, styleEnabled: true, elements: elements(problem), style: [{selector: 'node', style: {width: 30, height: 30}}]});
  repeatably(() => {
    sketch.layout({
      name: 'fcose', animate: false, quality: 'default', randomize: true, packComponents: true, nodeSeparation: 90,
      idealEdgeLength: 60, nodeRepulsion: 20000, gravity: 0.1, numIter: 2500,
    }).run();
  });
  const places = problem.parts.map((_, part) => ({...sketch.getElementById(`p${part}`).position()}));
  sketch.destroy();
  return places;
}

function elements(problem, places) {
  return [
    ...problem.parts.map(([ident], part) => ({data: {id: `p${part}`, label: ident, colour: ''}, ...(places && {position: {...places[part]}})})),
    ...problem.connections.map(([, a, b], c) => ({data: {id: `c${c}`, source: `p${a}`, target: `p${b}`}})),
  ];
}

const closest = 1.6;

/** Shows all of a drawing, and few parts not larger than life. */
export function fit(cy, padding) {
  cy.fit(undefined, padding);
  if (cy.zoom() > closest) {
    cy.zoom(closest);
    cy.center();
  }
}

/** A drawing of one plan's assembly in `container`. */
export class AssemblyGraph {
  constructor(container, problem, places) {
    this.labels = problem.parts.map(() => -1);
    const longest = Math.max(1, ...problem.parts.map(([ident]) => ident.length));
    const inside = longest <= 4;
    let palette = colours();
    const small = problem.parts.length > 60;
    const size = inside ? 14 + 4.5 * longest + (small ? 0 : 4) : 20;
    this.cy = cytoscape({
      container,
      elements: elements(problem, places),
      layout: {name: 'preset'},
      autoungrabify: true, autounselectify: true, userZoomingEnabled: false, userPanningEnabled: matchMedia('(pointer: fine)').matches,
      minZoom: 0.05, maxZoom: 4,
      style: [
        {
          selector: 'node',
          style: {
            width: size, height: size, shape: 'ellipse', label: 'data(label)', 'font-size': inside ? 12 : 11, 'font-family': 'system-ui, sans-serif',
            'font-weight': 500, color: () => (inside ? palette.onPiece : palette.ink), 'text-valign': inside ? 'center' : 'bottom', 'text-margin-y': inside ? 0 : 4,
            'text-wrap': 'ellipsis', 'text-max-width': inside ? size : 110, 'min-zoomed-font-size': 5,
            'background-color': (node) => pieceColour(palette, node.data('label0') ?? 0), 'border-width': 0,
            'text-outline-width': inside ? 0 : 2, 'text-outline-color': () => palette.surface,
          },
        },
        {
          selector: 'node.single',
          style: {'background-color': () => palette.surface, 'border-width': 1.5, 'border-color': () => palette.muted, 'border-style': 'solid', color: () => palette.muted},
        },
        {
          selector: 'node.moved',
          style: {'border-width': 4, 'border-color': () => palette.accent, 'border-style': 'solid'},
        },
        {selector: 'edge', style: {width: 2.5, 'line-color': () => palette.ink, 'curve-style': 'bezier', 'loop-direction': '45deg', opacity: 0.75}},
        {selector: 'edge.gone', style: {width: 1, 'line-color': () => palette.line, 'line-style': 'dotted', opacity: 1}},
        {selector: 'edge.now', style: {width: 4, 'line-color': () => palette.accent, 'line-style': 'dashed', opacity: 1, 'z-index': 5}},
        {selector: 'edge.now.there', style: {'line-style': 'solid'}},
      ],
    });
    onTheme(() => {
      palette = colours();
      this.cy.style().update();
    });
    this.nodes = problem.parts.map((_, part) => this.cy.getElementById(`p${part}`));
    this.edges = problem.connections.map((_, c) => this.cy.getElementById(`c${c}`));
    this.there = problem.connections.map(() => true);
    this.single = problem.parts.map(() => false);
    this.moved = [];
    this.now = [];
    this.fit();
  }

  /** Shows the state of `replay` and the step that led there, if any. */
  show(replay, step) {
    this.cy.batch(() => {
      const size = new Map();
      for (const label of replay.labels) size.set(label, (size.get(label) ?? 0) + 1);
      replay.labels.forEach((label, part) => {
        if (this.labels[part] !== label) {
          this.labels[part] = label;
          this.nodes[part].data('label0', label);
        }
        const single = size.get(label) === 1;
        if (this.single[part] !== single) {
          this.single[part] = single;
          this.nodes[part].toggleClass('single', single);
        }
      });
      this.there.forEach((was, c) => {
        const is = replay.present(c);
        if (was === is) return;
        this.there[c] = is;
        this.edges[c].toggleClass('gone', !is);
      });
      for (const part of this.moved) this.nodes[part].removeClass('moved');
      this.moved = step?.moved ?? [];
      for (const part of this.moved) this.nodes[part].addClass('moved');
      for (const c of this.now) this.edges[c].removeClass('now there');
      this.now = step ? cutOf(step) : [];
      for (const c of this.now) this.edges[c].addClass(this.there[c] ? 'now there' : 'now');
    });
  }

  zoom(factor) {
    const {cy} = this;
    cy.zoom({level: cy.zoom() * factor, renderedPosition: {x: cy.width() / 2, y: cy.height() / 2}});
  }
  fit() {
    fit(this.cy, 24);
  }
  resize() {
    this.cy.resize();
    this.fit();
  }
  /** The drawing as an address of a PNG, for print. */
  picture() {
    return this.cy.png({full: true, scale: 2, maxWidth: 2400, maxHeight: 2400});
  }
}
