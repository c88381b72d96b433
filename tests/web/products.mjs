// Products made for tests: a problem, and the binary glTF file with the shapes of its parts.

const faces = [0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4, 2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5];

/** A binary glTF file with a node for each of `meshes`: {id, points: [x, y, z, ...], corners: [...]}. */
export function glb(meshes) {
  const document = {asset: {version: '2.0'}, scene: 0, scenes: [{nodes: meshes.map((_, i) => i)}], nodes: [], meshes: [], accessors: [], bufferViews: []};
  const pieces = [];
  let size = 0;
  const accessor = (numbers, componentType, type, width) => {
    const bytes = Buffer.from(numbers.buffer, numbers.byteOffset, numbers.byteLength);
    document.bufferViews.push({buffer: 0, byteOffset: size, byteLength: bytes.length});
    pieces.push(bytes);
    size += bytes.length;
    return document.accessors.push({bufferView: document.bufferViews.length - 1, componentType, count: numbers.length / width, type}) - 1;
  };
  for (const {id, points, corners} of meshes) {
    const POSITION = accessor(Float32Array.from(points), 5126, 'VEC3', 3);
    const indices = accessor(Uint32Array.from(corners), 5125, 'SCALAR', 1);
    document.nodes.push({name: id, mesh: document.meshes.push({primitives: [{attributes: {POSITION}, indices}]}) - 1});
  }
  document.buffers = [{byteLength: size}];
  const text = Buffer.from(JSON.stringify(document));
  const json = Buffer.concat([text, Buffer.alloc((4 - (text.length % 4)) % 4, ' ')]);
  const head = Buffer.alloc(20);
  head.write('glTF');
  head.writeUInt32LE(2, 4);
  head.writeUInt32LE(28 + json.length + size, 8);
  head.writeUInt32LE(json.length, 12);
  head.write('JSON', 16);
  const chunk = Buffer.alloc(8);
  chunk.writeUInt32LE(size, 0);
  chunk.write('BIN\0', 4);
  return Buffer.concat([head, json, chunk, ...pieces]);
}

/** Whether two boxes have more in common than a face. */
const boxesOverlap = (a, b, slack) => [0, 1, 2].every((k) => a.low[k] < b.high[k] - slack && a.high[k] > b.low[k] + slack);

/** Whether two parts, of several boxes each, have more in common than faces. */
export const overlap = (a, b, slack = 1e-9) => a.boxes.some((one) => b.boxes.some((other) => boxesOverlap(one, other, slack)));

/** A part with each box changed. */
export const changed = (part, change) => ({id: part.id, boxes: part.boxes.map(({low, high}) => change(low, high))});

const partMesh = ({id, boxes}) => ({
  id,
  corners: boxes.flatMap((_, i) => faces.map((corner) => 8 * i + corner)),
  points: boxes.flatMap(({low, high}) => [...Array(8).keys()].flatMap((i) => [0, 1, 2].map((k) => ((i >> k) & 1 ? high : low)[k]))),
});

const axes = [['+x', 0, 1], ['-x', 0, -1], ['+y', 1, 1], ['-y', 1, -1], ['+z', 2, 1], ['-z', 2, -1]];

/** A problem of such parts, in metres: what touches is connected, and what would meet something on its way along an axis is blocked by it. */
export function boxProblem(parts, more = {}) {
  const far = (part, k, sign) => changed(part, (low, high) => ({low: low.map((x, i) => (i === k && sign < 0 ? -1e3 : x)), high: high.map((x, i) => (i === k && sign > 0 ? 1e3 : x))}));
  const connections = [];
  const blocked = [];
  parts.forEach((a, i) => parts.forEach((b, j) => {
    if (i < j && overlap(a, b, -1e-9)) connections.push({parts: [a.id, b.id]});
    const directions = axes.filter(([, k, sign]) => i !== j && overlap(far(a, k, sign), b)).map(([name]) => name);
    if (directions.length > 0) blocked.push({part: a.id, by: b.id, directions});
  }));
  const described = parts.map(({id, boxes}) => {
    const volumes = boxes.map(({low, high}) => low.reduce((product, x, k) => product * (high[k] - x), 1));
    const volume = volumes.reduce((sum, x) => sum + x);
    const position = [0, 1, 2].map((k) => boxes.reduce((sum, {low, high}, i) => sum + (volumes[i] * (low[k] + high[k])) / 2, 0) / volume);
    return {id, mass: Number((700 * volume).toPrecision(9)), position};
  });
  return {format: 'orasp-problem/1', name: 'Cabinet', parts: described, connections, blocking: {directions: axes.map(([name]) => name), blocked}, geometry: {file: 'cabinet.glb'}, ...more};
}

const metres = (list) => list.map((x) => x / 100);
const part = (id, ...boxes) => ({id, boxes: boxes.map(([low, high]) => ({low: metres(low), high: metres(high)}))});

/** A slab with square holes, from `z` to `top`: what is left of a grid of boxes. */
function slab(cutsX, cutsY, z, top, isHole) {
  const boxes = [];
  for (let i = 0; i + 1 < cutsX.length; ++i) for (let j = 0; j + 1 < cutsY.length; ++j) if (!isHole(i, j)) boxes.push([[cutsX[i], cutsY[j], z], [cutsX[i + 1], cutsY[j + 1], top]]);
  return boxes;
}

const foot = (id, x, y) => part(id, [[x - 3, y - 3, -4], [x + 3, y + 3, 0]], [[x - 1, y - 1, 0], [x + 1, y + 1, 2]]);
const odd = (i, j) => i % 2 === 1 && j % 2 === 1;

/** A cabinet: walls between a floor and a roof, a drawer with things in it, feet with pegs in the floor. */
export const cabinet = [
  part('floor', ...slab([0, 4, 6, 34, 36, 40], [0, 4, 6, 24, 26, 30], 0, 2, odd)),
  part('wall.1', [[0, 0, 2], [2, 30, 22]]),
  part('wall.2', [[38, 0, 2], [40, 30, 22]]),
  part('back', [[2, 28, 2], [38, 30, 22]]),
  part('roof', [[0, 0, 22], [40, 30, 24]]),
  part('tray', [[2, 0, 2], [38, 27, 3]], [[2, 0, 3], [3, 27, 12]], [[37, 0, 3], [38, 27, 12]], [[3, 26, 3], [37, 27, 12]]),
  part('front', [[2, -2, 2], [19, 0, 20]], [[21, -2, 2], [38, 0, 20]], [[19, -2, 2], [21, 0, 11]], [[19, -2, 13], [21, 0, 20]]),
  part('block.1', [[6, 6, 3], [14, 14, 11]]),
  part('block.2', [[18, 6, 3], [26, 14, 11]]),
  foot('foot.1', 5, 5),
  foot('foot.2', 35, 5),
  foot('foot.3', 5, 25),
  foot('foot.4', 35, 25),
  part('knob', [[19, -2, 11], [21, 0, 13]], [[18, -5, 10], [22, -2, 14]]),
];
export const cabinetFile = () => glb(cabinet.map(partMesh));

/** `count` wavy balls of about `triangles` triangles each, in a row of rows; each with a mesh of its own. */
export function balls(count, triangles) {
  const rings = Math.round(Math.sqrt(triangles / 2));
  const side = Math.ceil(Math.sqrt(count));
  const meshes = [];
  for (let n = 0; n < count; ++n) {
    const [x, y] = [3 * (n % side), 3 * Math.floor(n / side)];
    const points = [];
    const corners = [];
    for (let i = 0; i <= rings; ++i) {
      for (let j = 0; j < rings; ++j) {
        const [a, b] = [(Math.PI * i) / rings, (2 * Math.PI * j) / rings];
        const r = 0.01 * (1 + 0.05 * Math.sin(9 * a + n) * Math.cos(7 * b));
        points.push(0.01 * x + r * Math.sin(a) * Math.cos(b), 0.01 * y + r * Math.sin(a) * Math.sin(b), r * Math.cos(a));
        if (i === rings) continue;
        const [row, next] = [i * rings, (j + 1) % rings];
        corners.push(row + j, row + rings + j, row + next, row + next, row + rings + j, row + rings + next);
      }
    }
    meshes.push({id: `ball ${n}`, points, corners});
  }
  const parts = meshes.map(({id}) => ({id}));
  const connections = parts.slice(1).map(({id}, i) => ({parts: [`ball ${i}`, id]}));
  return {problem: {format: 'orasp-problem/1', name: 'Balls', parts, connections, objective: {type: 'travel'}, geometry: {file: 'balls.glb'}}, file: glb(meshes)};
}
