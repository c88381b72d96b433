// The state-action graph H: dagre puts each layer in an order with few crossings, cytoscape draws it.
import dagre from '@dagrejs/dagre';
import cytoscape from 'cytoscape';
import {fit} from './assembly.js';
import {number} from './format.js';
import {colours, onTheme} from './theme.js';

const across = 34;

/** Places of the nodes: the layers are those of the data, and dagre orders each. `aspect`: height of the frame by its width. */
function places({nodes, actions}, aspect) {
  const graph = new dagre.graphlib.Graph();
  graph.setGraph({rankdir: 'TB', nodesep: 10, ranksep: 30, ranker: 'longest-path'});  // another takes minutes
  graph.setDefaultEdgeLabel(() => ({}));
  nodes.forEach((_, node) => graph.setNode(String(node), {width: 20, height: 20}));
  for (const [from, to] of actions) graph.setEdge(String(from), String(to));
  dagre.layout(graph);
  const layers = new Map();
  nodes.forEach(([layer], node) => {
    if (!layers.has(layer)) layers.set(layer, []);
    layers.get(layer).push(node);
  });
  const widest = across * Math.max(...[...layers.values()].map((members) => members.length));
  const down = Math.max(60, (aspect * widest) / Math.max(1, layers.size - 1));
  const found = nodes.map(() => null);
  for (const [layer, members] of layers) {
    members.sort((a, b) => graph.node(String(a)).x - graph.node(String(b)).x);
    members.forEach((node, i) => (found[node] = {x: (i - (members.length - 1) / 2) * across, y: layer * down}));
  }
  return found;
}

const kinds = ['state', 'pruned', 'dead'];

export class StateGraph {
  /** `drawing` of the data; `onPick` is called with the number of a state that is pointed at, or null. */
  constructor(container, drawing, onPick) {
    const at = places(drawing, container.clientHeight / Math.max(1, container.clientWidth));
    const onPath = new Set(drawing.paths.flatMap((path) => path.slice(1).map((to, i) => `${path[i]} ${to}`)));
    const pathNodes = new Set(drawing.paths.flat());
    let palette = colours();
    const many = drawing.nodes.length > 120;
    this.cy = cytoscape({
      container,
      elements: [
        ...drawing.nodes.map(([, , kind], node) => ({data: {id: `s${node}`, node}, position: at[node], classes: `${kinds[kind]}${pathNodes.has(node) ? ' path' : ''}`})),
        ...drawing.actions.map(([from, to, , , pruned], a) => ({data: {id: `a${a}`, source: `s${from}`, target: `s${to}`}, classes: `${pruned ? 'pruned' : ''}${onPath.has(`${from} ${to}`) ? ' path' : ''}`})),
      ],
      layout: {name: 'preset'},
      autoungrabify: true, autounselectify: true, userZoomingEnabled: false, userPanningEnabled: matchMedia('(pointer: fine)').matches, minZoom: 0.05, maxZoom: 4,
      style: [
        {selector: 'node', style: {width: 18, height: 18, 'background-color': () => palette.pieces[0]}},
        {selector: 'edge', style: {width: many ? 0.8 : 1.2, 'line-color': () => palette.muted, opacity: many ? 0.35 : 0.6, 'curve-style': 'straight'}},
        {selector: 'node.pruned', style: {'background-color': () => palette.surface, 'border-width': 1.5, 'border-color': () => palette.muted, 'border-style': 'dashed', opacity: 0.7}},
        {selector: 'edge.pruned', style: {'line-color': () => palette.line, 'line-style': 'dashed', opacity: 0.9, width: 0.8}},
        {selector: 'node.dead', style: {'background-color': () => palette.warn, shape: 'diamond'}},
        {selector: 'node.path', style: {'background-color': () => palette.accent, width: 22, height: 22}},
        {selector: 'edge.path', style: {'line-color': () => palette.accent, width: 4, opacity: 1, 'line-style': 'solid', 'z-index': 5}},
        {selector: 'node.here', style: {'border-width': 5, 'border-color': () => palette.ink, width: 28, height: 28}},
        {selector: 'node.picked', style: {'border-width': 3, 'border-color': () => palette.ink}},
      ],
    });
    onTheme(() => {
      palette = colours();
      this.cy.style().update();
    });
    let picked = null;
    const pick = (node) => {
      picked?.removeClass('picked');
      picked = node;
      picked?.addClass('picked');
      onPick(node ? node.data('node') : null);
    };
    this.cy.on('mouseover tap', 'node', (event) => pick(event.target));
    this.here = [];
    this.fit();
  }

  /** Marks the states (numbers) in which the plans are now. */
  mark(nodes) {
    this.cy.batch(() => {
      for (const node of this.here) node.removeClass('here');
      this.here = nodes.map((node) => this.cy.getElementById(`s${node}`));
      for (const node of this.here) node.addClass('here');
    });
  }
  zoom(factor) {
    const {cy} = this;
    cy.zoom({level: cy.zoom() * factor, renderedPosition: {x: cy.width() / 2, y: cy.height() / 2}});
  }
  fit() {
    fit(this.cy, 16);
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

/** What a state is, in words. */
export function stateWords(problem, drawing, node) {
  const [, present, kind, value] = drawing.nodes[node];
  const names = present.map((c) => problem.connections[c][0]);
  const what = names.length === 0 ? 'Nothing connected' : `Connected: ${names.join(', ')}`;
  const more = ['', '. A precedence prunes this state', '. A dead end: nothing more is legal'][kind];
  return `${what}${more}.${kind === 0 && value !== null ? ` Best reward still to come: ${number(value)}.` : ''}`;
}
