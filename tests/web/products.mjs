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

const boxMesh = ({id, low, high}) => ({id, corners: faces, points: [...Array(8).keys()].flatMap((i) => [0, 1, 2].map((k) => ((i >> k) & 1 ? high : low)[k]))});

/** Whether two boxes have more in common than a face. */
export const overlap = (a, b, slack = 1e-9) => [0, 1, 2].every((k) => a.low[k] < b.high[k] - slack && a.high[k] > b.low[k] + slack);

const axes = [['+x', 0, 1], ['-x', 0, -1], ['+y', 1, 1], ['-y', 1, -1], ['+z', 2, 1], ['-z', 2, -1]];

/** A problem of boxes, in metres: what touches is connected, and what would meet something on its way along an axis is blocked by it. */
export function boxProblem(boxes, more = {}) {
  const far = (box, k, sign) => ({low: box.low.map((x, i) => (i === k && sign < 0 ? -1e3 : x)), high: box.high.map((x, i) => (i === k && sign > 0 ? 1e3 : x))});
  const connections = [];
  const blocked = [];
  boxes.forEach((a, i) => boxes.forEach((b, j) => {
    if (i < j && overlap(a, b, -1e-9)) connections.push({parts: [a.id, b.id]});
    const directions = axes.filter(([, k, sign]) => i !== j && overlap(far(a, k, sign), b)).map(([name]) => name);
    if (directions.length > 0) blocked.push({part: a.id, by: b.id, directions});
  }));
  const parts = boxes.map(({id, low, high}) => ({id, mass: low.reduce((product, x, k) => product * (high[k] - x), 7800), position: low.map((x, k) => (x + high[k]) / 2)}));
  return {format: 'orasp-problem/1', name: 'Cabinet', parts, connections, blocking: {directions: axes.map(([name]) => name), blocked}, geometry: {file: 'cabinet.glb'}, ...more};
}

const box = (id, low, high) => ({id, low: low.map((x) => x / 100), high: high.map((x) => x / 100)});

/** A cabinet: walls between a floor and a roof, a drawer in it with things in it, feet below, pins that hold the roof. */
export const cabinet = [
  box('floor', [0, 0, 0], [40, 30, 2]),
  box('wall.1', [0, 0, 2], [2, 30, 22]),
  box('wall.2', [38, 0, 2], [40, 30, 22]),
  box('back', [2, 28, 2], [38, 30, 22]),
  box('roof', [0, 0, 22], [40, 30, 24]),
  box('tray', [2, 0, 2], [38, 28, 4]),
  box('front', [2, -2, 2], [38, 0, 20]),
  box('block.1', [6, 6, 4], [14, 14, 12]),
  box('block.2', [18, 6, 4], [26, 14, 12]),
  box('foot.1', [2, 2, -4], [6, 6, 0]),
  box('foot.2', [34, 2, -4], [38, 6, 0]),
  box('foot.3', [2, 24, -4], [6, 28, 0]),
  box('foot.4', [34, 24, -4], [38, 28, 0]),
  box('knob', [18, -5, 10], [22, -2, 14]),
];
export const cabinetFile = () => glb(cabinet.map(boxMesh));

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
