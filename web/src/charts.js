// Charts by d3's scales, shapes and axes, as SVG: sharp in print, coloured by the style sheet.
import {axisBottom, axisLeft} from 'd3-axis';
import {scaleLinear} from 'd3-scale';
import {select} from 'd3-selection';
import {area, curveBasis, curveLinear, curveStepAfter, line} from 'd3-shape';
import {number} from './format.js';

const height = 240;

/** A frame for a chart that is drawn anew whenever its width changes. `draw` gets the selection of the svg and its width. */
function chart(container, label, draw) {
  const root = select(container);
  let last = 0;
  const again = (force) => {
    const width = Math.max(260, Math.floor(container.clientWidth));
    if (!force && width === last) return;
    last = width;
    root.selectAll('svg').remove();
    draw(root.append('svg').attr('viewBox', `0 0 ${width} ${height}`).attr('width', width).attr('height', height).attr('role', 'img').attr('aria-label', label()), width);
  };
  new ResizeObserver(() => again(false)).observe(container);
  again(true);
  return () => again(true);
}

/** The numbers' extent, widened a little so that lines do not touch the frame. */
function domain(values) {
  const known = values.filter((value) => value !== null && Number.isFinite(value));
  let least = Math.min(...known);
  let greatest = Math.max(...known);
  if (!(greatest > least)) {
    const pad = Math.max(1e-6, Math.abs(greatest) * 0.1);
    least -= pad;
    greatest += pad;
  }
  const pad = (greatest - least) * 0.06;
  return [least - pad, greatest + pad];
}

const tickText = (value) => number(Number(value.toPrecision(6)));

function axes(svg, x, y, width, left, bottom, xTitle, yTitle) {
  const xAxis = axisBottom(x).ticks(Math.max(2, Math.floor((width - left) / 90))).tickSizeOuter(0).tickFormat(tickText);
  svg.append('g').attr('class', 'axis').attr('transform', `translate(0,${height - bottom})`).call(xAxis);
  svg.append('text').attr('class', 'axis-title').attr('x', width - 8).attr('y', height - 4).attr('text-anchor', 'end').text(xTitle);
  if (!y) return;
  svg.append('g').attr('class', 'axis').attr('transform', `translate(${left},0)`).call(axisLeft(y).ticks(5).tickSizeOuter(0).tickFormat(tickText));
  svg.append('g').attr('class', 'grid').attr('transform', `translate(${left},0)`).call(axisLeft(y).ticks(5).tickSize(-(width - left - 12)).tickFormat('').tickSizeOuter(0));
  svg.append('text').attr('class', 'axis-title').attr('x', left).attr('y', 11).attr('text-anchor', 'start').text(yTitle);
}

const leftMargin = (values) => 18 + 7 * Math.max(...domain(values).map((value) => tickText(Number(value.toPrecision(3))).length), 3);

/** What the lines of a chart are called: a list with a piece of each. */
export function lineKey(names) {
  const list = select(document.createElement('ul')).attr('class', 'key');
  names.forEach((name, i) => {
    const item = list.append('li');
    item.append('svg').attr('viewBox', '0 0 30 10').attr('class', 'line-key').attr('aria-hidden', 'true').append('path').attr('class', `series series-${i % 4}`).attr('d', 'M0 5H30');
    item.append('span').text(name);
  });
  return list.node();
}

/** Lines over a common axis: series [{name, points: [[x, y]], step, kind}], levels [{name, y}]. Returns {redraw, mark}. */
export function lineChart(container, {series, levels, xTitle, yTitle, label}) {
  let svg = null;
  let scales = null;
  let marks = null;
  const redraw = chart(container, label, (target, width) => {
    svg = target;
    const lines = series();
    const all = [...lines.flatMap(({points}) => points.map(([, y]) => y)), ...levels().map(({y}) => y)];
    const left = leftMargin(all);
    const bottom = 36;
    const xs = lines.flatMap(({points}) => points.map(([x]) => x));
    const x = scaleLinear().domain([Math.min(...xs), Math.max(...xs, Math.min(...xs) + 1)]).range([left, width - 12]);
    const y = scaleLinear().domain(domain(all)).range([height - bottom, 22]);
    scales = {x, y};
    axes(svg, x, y, width, left, bottom, xTitle, yTitle);
    for (const {name, y: value} of levels()) {
      svg.append('line').attr('class', 'level').attr('x1', left).attr('x2', width - 12).attr('y1', y(value)).attr('y2', y(value));
      svg.append('text').attr('class', 'level-name').attr('x', left + 6).attr('y', y(value) + (y(value) < 40 ? 13 : -5)).text(name);
    }
    lines.forEach(({points, step, kind}, i) => {
      const known = points.filter(([, value]) => value !== null);
      if (known.length === 0) return;
      const path = line().x(([px]) => x(px)).y(([, py]) => y(py)).curve(step ? curveStepAfter : curveLinear);
      svg.append('path').attr('class', `series series-${kind ?? i % 4}`).attr('d', path(known));
    });
    marks = svg.append('g');
  });
  return {
    redraw,
    /** Marks the points [[x, y], ...]. */
    mark(points) {
      marks.selectAll('*').remove();
      for (const [px, py] of points) {
        if (py === null) continue;
        marks.append('line').attr('class', 'here').attr('x1', scales.x(px)).attr('x2', scales.x(px)).attr('y1', scales.y.range()[0]).attr('y2', scales.y.range()[1]);
        marks.append('circle').attr('class', 'here').attr('r', 5).attr('cx', scales.x(px)).attr('cy', scales.y(py));
      }
    },
  };
}

/** A violin of a distribution, lying, with its quartiles, and lines at `marks` [{name, value, kind}]. */
export function violin(container, {sample, marks, label}) {
  return chart(container, label, (svg, width) => {
    const left = 12;
    const bottom = 36;
    const x = scaleLinear().domain(domain([...sample.density.map(([reward]) => reward), ...marks.map(({value}) => value)])).range([left, width - 12]);
    const rows = marks.length;
    const middle = 22 + 17 * rows + (height - bottom - 30 - 17 * rows) / 2;
    const half = (height - bottom - 30 - 17 * rows) / 2;
    axes(svg, x, null, width, left, bottom, 'reward');
    const most = Math.max(...sample.density.map(([, density]) => density));
    const body = area().x(([reward]) => x(reward)).y0(([, density]) => middle - (density / most) * half).y1(([, density]) => middle + (density / most) * half).curve(curveBasis);
    svg.append('path').attr('class', 'violin').attr('d', body(sample.density));
    const [lower, median, upper] = sample.quartiles;
    svg.append('line').attr('class', 'whisker').attr('x1', x(sample.min)).attr('x2', x(sample.max)).attr('y1', middle).attr('y2', middle);
    svg.append('rect').attr('class', 'quartiles').attr('x', x(lower)).attr('width', Math.max(2, x(upper) - x(lower))).attr('y', middle - 7).attr('height', 14).attr('rx', 2);
    svg.append('circle').attr('class', 'median').attr('cx', x(median)).attr('cy', middle).attr('r', 4.5);
    marks.forEach(({name, value, kind}, i) => {
      const at = x(value);
      const y = 14 + 17 * i;
      svg.append('line').attr('class', `mark mark-${kind}`).attr('x1', at).attr('x2', at).attr('y1', y + 4).attr('y2', height - bottom);
      const right = at > width / 2;
      svg.append('text').attr('class', 'mark-name').attr('x', right ? at - 5 : at + 5).attr('y', y + 6).attr('text-anchor', right ? 'end' : 'start').text(name);
    });
  });
}
