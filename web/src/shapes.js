// The true parts in space: what the file of shapes holds, how each step takes its piece out, all of it apart, and the pictures
// of the book.
import {BufferAttribute, BufferGeometry, Color, ConeGeometry, CylinderGeometry, GreaterDepth, Group, LineBasicMaterial, LineDashedMaterial, LineSegments, Matrix4, Mesh, MeshBasicMaterial, MeshLambertMaterial, Vector3} from 'three';
import {GLTFLoader} from 'three/addons/loaders/GLTFLoader.js';
import {CSS2DObject} from 'three/addons/renderers/CSS2DRenderer.js';
import {around, centre, explode, offsets} from './explosion.js';
import {kindsOf} from './kinds.js';
import {Space, reducedMotion} from './space.js';

const seconds = 0.7;  // that a piece takes for its way

/** Reads the shapes: for each part {surface, edges, place, colour, box}. `text` is a binary glTF file in base64. */
export async function readShapes(text, count) {
  const bytes = Uint8Array.from(atob(text), (character) => character.charCodeAt(0));
  const {scene} = await new GLTFLoader().parseAsync(bytes.buffer, '');
  scene.updateMatrixWorld(true);
  const shapes = new Array(count);
  scene.traverse((node) => {
    const {part} = node.userData;
    if (part === undefined) return;
    const shape = {place: node.matrixWorld.clone()};
    node.traverse((drawn) => {
      if (drawn.isLineSegments) shape.edges = drawn.geometry;
      else if (drawn.isMesh) {
        shape.surface = drawn.geometry;
        const {r, g, b} = drawn.material.color;
        shape.colour = r === 1 && g === 1 && b === 1 ? null : drawn.material.color.clone();
      }
    });
    const {surface, place} = shape;
    const point = new Vector3();
    const points = surface.getAttribute('position');
    const low = new Vector3(Infinity, Infinity, Infinity);
    const high = low.clone().negate();
    for (let i = 0; i < points.count; ++i) {
      point.fromBufferAttribute(points, i).applyMatrix4(place);
      low.min(point);
      high.max(point);
    }
    shape.box = {low: low.toArray(), high: high.toArray()};
    shapes[part] = shape;
  });
  return shapes;
}

const corners = ({low, high}, offset = [0, 0, 0]) => [...Array(8).keys()].map((i) => new Vector3(...[0, 1, 2].map((k) => ((i >> k) & 1 ? high[k] : low[k]) + offset[k])));

const tints = {
  // How much of the background is mixed in, and how strong edges are.
  own: {mix: 0.08, edge: 0.75},
  pale: {mix: 0.7, edge: 0.45},
  bright: {mix: 0, edge: 0.6},
  ghost: {mix: 0.5, edge: 0.1, opacity: 0.07},
};

const paper = {ink: '#1d232a', muted: '#59626c', surface: '#ffffff', accent: '#0b6e69', pieces: ['#3c4858', '#7a5aa8', '#a3621d', '#2f73a8', '#7a7a1f', '#a8456a', '#3f7d4d']};

export class ShapeSpace extends Space {
  constructor(container, problem, plan, shapes, theme) {
    super(container);
    this.problem = problem;
    this.theme = theme;
    this.palette = theme.colours();
    this.shapes = shapes;
    this.kinds = kindsOf(problem);
    this.boxes = shapes.map(({box}) => box);
    this.moves = explode(plan, this.boxes);
    this.whole = around(this.boxes);
    this.size = new Vector3(...this.whole.high).distanceTo(new Vector3(...this.whole.low)) || 1;
    this.share = 0;
    this.labelled = false;
    this.plan = plan;
    this.materials = new Map();
    this.marked = shapes.map(() => 'own');
    this.moving = null;  // {move, distance} of the step that is shown

    this.parts = problem.parts.map(([ident], part) => {
      const {surface, edges, place} = shapes[part];
      const group = new Group();
      const body = new Mesh(surface);
      body.matrixAutoUpdate = false;
      body.matrix.copy(place);
      group.add(body);
      // What shines through where something hides the part.
      const veil = new Mesh(surface);
      veil.matrixAutoUpdate = false;
      veil.matrix.copy(place);
      veil.renderOrder = 1;
      veil.visible = false;
      group.add(veil);
      let rim = null;
      if (edges) {
        rim = new LineSegments(edges);
        rim.matrixAutoUpdate = false;
        rim.matrix.copy(place);
        group.add(rim);
      }
      const text = document.createElement('span');
      text.className = 'space-label';
      text.textContent = ident;
      const label = new CSS2DObject(text);
      label.position.set(...centre(this.boxes[part]));
      label.visible = false;
      group.add(label);
      this.scene.add(group);
      return {group, body, veil, rim, text, label};
    });

    this.trails = new LineSegments(new BufferGeometry(), new LineDashedMaterial({dashSize: 0.014 * this.size, gapSize: 0.008 * this.size, transparent: true, opacity: 0.8}));
    this.trails.frustumCulled = false;
    this.scene.add(this.trails);
    this.arrow = this.makeArrow();

    this.controls.enablePan = true;
    this.camera.near = 0.002 * this.size;
    this.camera.far = 60 * this.size;
    this.turnHome();
    theme.onTheme(() => {
      this.palette = theme.colours();
      this.paint();
      this.draw();
    });
    this.paint();
    this.view = this.fitting([this.whole], [[0, 0, 0]]);
    this.look(this.view);
    this.resize();
  }

  // -------------------------------------------------------------------------------------------------------------------
  // Colours

  /** What to draw a part with: `tint` one of tints. */
  material(part, tint) {
    const {palette} = this;
    const kind = this.kinds.of[part];
    const key = `${tint} ${tint === 'bright' ? '' : kind} ${this.shapes[part].colour?.getHexString() ?? ''}`;
    if (!this.materials.has(key)) {
      const {mix, edge, opacity = 1} = tints[tint];
      const surface = new Color(palette.surface);
      const own = tint === 'bright' ? new Color(palette.accent) : this.shapes[part].colour?.clone() ?? new Color(palette.pieces[1 + (kind % 6)]).lerp(surface, 0.3);
      this.materials.set(key, {
        veil: tint === 'bright' ? new MeshBasicMaterial({color: own, transparent: true, opacity: 0.45, depthFunc: GreaterDepth, depthWrite: false}) : null,
        body: new MeshLambertMaterial({color: own.clone().lerp(surface, mix), transparent: opacity < 1 || tint === 'bright', opacity, depthWrite: opacity === 1, polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 1}),
        rim: new LineBasicMaterial({color: own.clone().lerp(new Color(palette.ink), 0.75), transparent: true, opacity: edge}),
      });
    }
    return this.materials.get(key);
  }

  paint() {
    this.materials.clear();
    this.trails.material.color.set(this.palette.ink);
    for (const piece of this.arrow.children) piece.material.color.set(this.palette.ink);
    this.parts.forEach((_, part) => this.tint(part, this.marked[part]));
  }

  tint(part, tint) {
    const {body, veil, rim} = this.parts[part];
    const material = this.material(part, tint);
    const bright = tint === 'bright';
    this.marked[part] = tint;
    body.material = material.body;
    body.renderOrder = bright ? 2 : 0;
    veil.visible = bright;
    if (bright) veil.material = material.veil;
    if (!rim) return;
    rim.material = material.rim;
    rim.renderOrder = bright ? 3 : 0;
  }

  // -------------------------------------------------------------------------------------------------------------------
  // The camera

  /** From the front and above, on the side from which the plan's moves along the ground are seen best. */
  turnHome() {
    const reach = [0, 1].map((k) => this.moves.reduce((sum, {direction, apart}) => sum + Math.abs(direction[k]) * apart, 0));
    this.camera.position.set(...(reach[0] < reach[1] ? [1.45, -0.8, 0.85] : [0.8, -1.45, 0.85]));
    this.camera.lookAt(0, 0, 0);
    this.camera.updateMatrixWorld(true);
  }

  /** The place from which boxes, each moved by each of some offsets, fill the frame, seen as the camera is turned now: {target, distance}. */
  fitting(boxes, moved) {
    const [right, up, back] = [new Vector3(), new Vector3(), new Vector3()];
    this.camera.matrixWorld.extractBasis(right, up, back);
    const tall = 0.88 * Math.tan((this.camera.fov * Math.PI) / 360);
    const wide = tall * this.camera.aspect;
    // Each point asks that its distance from the middle be at most `wide` or `tall` times its distance from the camera.
    const most = [-Infinity, -Infinity, -Infinity, -Infinity];
    const depth = [Infinity, -Infinity];
    boxes.forEach((box, i) => {
      for (const point of corners(box, moved[i])) {
        const [x, y, z] = [point.dot(right), point.dot(up), point.dot(back)];
        [x / wide, -x / wide, y / tall, -y / tall].forEach((w, k) => (most[k] = Math.max(most[k], w + z)));
        depth[0] = Math.min(depth[0], z);
        depth[1] = Math.max(depth[1], z);
      }
    });
    const z = Math.max((most[0] + most[1]) / 2, (most[2] + most[3]) / 2, depth[1] + 0.1 * this.size);
    const middle = (depth[0] + depth[1]) / 2;
    const target = right.multiplyScalar((wide * (most[0] - most[1])) / 2).addScaledVector(up, (tall * (most[2] - most[3])) / 2).addScaledVector(back, middle);
    return {target, distance: z - middle};
  }

  /** Goes there without turning. */
  look({target, distance}) {
    const back = new Vector3();
    this.camera.matrixWorld.extractBasis(new Vector3(), new Vector3(), back);
    this.controls.target.copy(target);
    this.camera.position.copy(target).addScaledVector(back, distance);
    this.camera.updateMatrixWorld(true);
    this.sun.position.copy(this.camera.position).sub(target).applyAxisAngle(new Vector3(0, 0, 1), -0.7).add(new Vector3(0, 0, distance * 0.6));
  }

  // -------------------------------------------------------------------------------------------------------------------
  // A step, and the explosion

  /** Shows the state of `replay` and the step that led there. */
  show(replay, step, order, animate = true) {
    this.last = [replay, step, order];
    cancelAnimationFrame(this.frame);
    const size = new Map();
    for (const label of replay.labels) size.set(label, (size.get(label) ?? 0) + 1);
    const at = step ? this.plan.steps.indexOf(step) : -1;
    const move = this.moves.find((one) => one.step === at) ?? null;
    const moved = new Set(step?.moved ?? []);
    const kept = new Set([step?.split?.[0], ...(step?.rest ?? []).map(([label]) => label)]);
    this.parts.forEach((_, part) => {
      const label = replay.labels[part];
      const alone = size.get(label) === 1 && !kept.has(label);
      if (moved.has(part)) this.tint(part, 'bright');
      else if (this.share > 0 || !step) this.tint(part, !step && alone && this.share === 0 && replay.removed > 0 ? 'pale' : 'own');
      else this.tint(part, alone ? 'ghost' : 'pale');
    });
    this.moving = move;
    if (this.share > 0) {
      this.place(this.share, 0);
      this.look((this.view = this.wanted()));
      this.draw();
      return;
    }
    const [from, to] = order === 'assembly' ? [1, 0] : [0, 1];
    const begin = this.view;
    const end = this.wanted();
    const show = (share) => {
      this.view = {target: begin.target.clone().lerp(end.target, Math.min(1, 2 * share)), distance: begin.distance + (end.distance - begin.distance) * Math.min(1, 2 * share)};
      this.place(0, from + (to - from) * share);
      this.look(this.view);
      this.draw();
    };
    if (!animate || reducedMotion.matches || !move) return show(1);
    const start = performance.now();
    const tick = (now) => {
      const share = Math.min(1, Math.max(0, (now - start) / (1000 * seconds)));
      show(share < 0.5 ? 2 * share * share : 1 - 2 * (1 - share) ** 2);
      if (share < 1) this.frame = requestAnimationFrame(tick);
    };
    this.frame = requestAnimationFrame(tick);
    return show(0);
  }

  /** Where the camera should be for what is shown. */
  wanted() {
    if (this.share > 0) return this.fitting(this.boxes, this.offsets);
    const {moving} = this;
    const boxes = this.boxes.slice();
    const moved = boxes.map(() => [0, 0, 0]);
    for (const part of moving?.parts ?? []) {
      boxes.push(this.boxes[part]);
      moved.push(moving.direction.map((x) => x * moving.out));
    }
    return this.fitting(boxes, moved);
  }

  /** Puts the parts where they are at `share` of the explosion, or where the moving piece is `out` of its way out. */
  place(share, out) {
    this.offsets = offsets(this.moves, this.parts.length, share * this.moves.length);
    if (share === 0 && this.moving) {
      const {parts, direction, out: distance} = this.moving;
      for (const part of parts) this.offsets[part] = direction.map((x) => x * distance * out);
    }
    this.parts.forEach(({group}, part) => group.position.set(...this.offsets[part]));
    this.drawTrails(share, out);
  }

  /** From the place of each piece to where it is now. */
  drawTrails(share, out) {
    const points = [];
    const trail = (from, to) => points.push(...from, ...to);
    if (share > 0) {
      const done = share * this.moves.length;
      const ways = this.boxes.map(() => [0, 0, 0]);
      this.moves.forEach(({parts, direction, apart}, i) => {
        const length = apart * Math.min(1, Math.max(0, done - i));
        if (length === 0) return;
        const middle = centre(around(parts.map((part) => this.boxes[part])));
        const from = middle.map((x, k) => x + ways[parts[0]][k]);
        trail(from, from.map((x, k) => x + direction[k] * length));
        for (const part of parts) for (let k = 0; k < 3; ++k) ways[part][k] += direction[k] * length;
      });
    } else if (this.moving && out > 0) {
      const {parts, direction, out: distance} = this.moving;
      const from = centre(around(parts.map((part) => this.boxes[part])));
      trail(from, from.map((x, k) => x + direction[k] * distance * out));
    }
    this.trails.geometry.dispose();
    this.trails.geometry = new BufferGeometry();
    this.trails.geometry.setAttribute('position', new BufferAttribute(new Float32Array(points), 3));
    this.trails.computeLineDistances();
    this.trails.visible = points.length > 0;
  }

  /** Takes the product apart as far as `share` says, 0 to 1: the steps of the plan one after the other. */
  explode(share) {
    const before = this.share;
    this.share = share;
    cancelAnimationFrame(this.frame);
    if (before > 0 !== share > 0) {
      this.show(...this.last, false);
      return;
    }
    this.place(share, 0);
    this.look((this.view = this.wanted()));
    this.draw();
  }

  /** How many pieces are out, and how many there are to come out. */
  get exploded() {
    return [Math.round(this.share * this.moves.length), this.moves.length];
  }

  setLabels(on) {
    this.labelled = on;
    this.draw();
  }

  // -------------------------------------------------------------------------------------------------------------------
  // Drawing

  draw() {
    if (this.parts) this.chooseLabels();
    super.draw();
  }

  /** Labels that would lie on others are left out: what moves goes first, then what is near. */
  chooseLabels() {
    const {clientWidth: width, clientHeight: height} = this.container;
    const taken = [];
    const point = new Vector3();
    const order = this.parts.map(({group, label}, part) => {
      point.copy(label.position).add(group.position).project(this.camera);
      return {part, x: ((point.x + 1) / 2) * width, y: ((1 - point.y) / 2) * height, depth: point.z, first: this.marked[part] === 'bright' ? 0 : 1};
    }).sort((a, b) => a.first - b.first || a.depth - b.depth);
    for (const {part, x, y} of order) {
      const {label, text} = this.parts[part];
      label.visible = this.labelled && this.marked[part] !== 'ghost';
      if (!label.visible) continue;
      const half = Math.min(72, 4 + 3.1 * text.textContent.length);
      const own = [x - half, x + half, y - 9, y + 9];
      label.visible = own[0] > 0 && own[1] < width && taken.every(([left, right, top, bottom]) => own[1] < left || own[0] > right || own[3] < top || own[2] > bottom);
      if (label.visible) taken.push(own);
      text.className = this.marked[part] === 'bright' ? 'space-label moved' : 'space-label';
    }
  }

  resize() {
    const {aspect, fov} = this.camera;
    super.resize();
    if (!this.last || (aspect === this.camera.aspect && fov === this.camera.fov)) return;
    this.look((this.view = this.wanted()));
    this.draw();
  }
  zoom(factor) {
    this.camera.zoom = Math.min(20, Math.max(0.2, this.camera.zoom * factor));
    this.camera.updateProjectionMatrix();
    this.draw();
  }
  fit() {
    this.camera.zoom = 1;
    this.turnHome();
    this.camera.updateProjectionMatrix();
    this.look((this.view = this.wanted()));
    this.draw();
  }

  // -------------------------------------------------------------------------------------------------------------------
  // The book

  makeArrow() {
    const arrow = new Group();
    const shaft = new Mesh(new CylinderGeometry(1, 1, 1, 20), new MeshBasicMaterial({depthTest: false, transparent: true, opacity: 0.9}));
    const head = new Mesh(new ConeGeometry(1, 1, 28), new MeshBasicMaterial({depthTest: false, transparent: true, opacity: 0.9}));
    shaft.renderOrder = head.renderOrder = 10;
    arrow.add(shaft, head);
    arrow.visible = false;
    this.scene.add(arrow);
    return arrow;
  }

  /** `size` of what is shown, by which the arrow is as thick in each picture. */
  pointArrow(from, to, size) {
    const way = to.clone().sub(from);
    const length = way.length();
    this.arrow.visible = length > 1e-9;
    if (!this.arrow.visible) return;
    const thick = Math.min(0.01 * size, 0.08 * length);
    const [shaft, head] = this.arrow.children;
    const tip = Math.min(6 * thick, 0.5 * length);
    shaft.scale.set(thick, length - tip, thick);
    shaft.position.set(0, (length - tip) / 2, 0);
    head.scale.set(2.6 * thick, tip, 2.6 * thick);
    head.position.set(0, length - tip / 2, 0);
    this.arrow.position.copy(from);
    this.arrow.quaternion.setFromUnitVectors(new Vector3(0, 1, 0), way.normalize());
  }

  /**
   * Draws pictures on paper, as addresses of images, between begin() and end(): the whole product, apart as far as `share` says,
   * and a step, what it joins and nothing else. All are seen from one side.
   */
  pictures(width, height) {
    const kept = {
      share: this.share, labelled: this.labelled, view: this.view, zoom: this.camera.zoom, aspect: this.camera.aspect, fov: this.camera.fov, ratio: this.renderer.getPixelRatio(),
      position: this.camera.position.clone(), quaternion: this.camera.quaternion.clone(), target: this.controls.target.clone(),
    };
    cancelAnimationFrame(this.frame);
    const begin = () => {
      this.palette = paper;
      this.share = 0;
      this.labelled = false;
      this.camera.zoom = 1;
      this.camera.aspect = width / height;
      this.camera.fov = 35;
      this.camera.updateProjectionMatrix();
      this.turnHome();
      this.renderer.setPixelRatio(1);
      this.renderer.setSize(width, height, false);
      this.paint();
    };
    const take = () => {
      this.renderer.render(this.scene, this.camera);
      return this.renderer.domElement.toDataURL('image/png');
    };
    const only = (parts) => this.parts.forEach(({group}, part) => (group.visible = !parts || parts.has(part)));
    return {
      begin,
      whole: (share) => {
        this.moving = null;
        only(null);
        this.parts.forEach((_, part) => this.tint(part, 'own'));
        this.place(share, 0);
        this.look(this.fitting(this.boxes, this.offsets));
        return take();
      },
      step: (move, rest) => {
        this.moving = move;
        const there = new Set([...move.parts, ...rest]);
        only(there);
        for (const part of rest) this.tint(part, 'pale');
        for (const part of move.parts) this.tint(part, 'bright');
        this.place(0, 1);
        const moved = move.direction.map((x) => x * move.out);
        const boxes = [...there].map((part) => this.boxes[part]);
        this.look(this.fitting([...boxes, ...move.parts.map((part) => this.boxes[part])], [...boxes.map(() => [0, 0, 0]), ...move.parts.map(() => moved)]));
        const box = around(move.parts.map((part) => this.boxes[part]));
        const middle = new Vector3(...centre(box));
        const direction = new Vector3(...move.direction);
        const reach = Math.max(...corners(box).map((point) => point.clone().sub(middle).dot(direction.clone().negate())));
        const front = middle.clone().addScaledVector(direction, -reach);
        this.trails.visible = false;
        const shown = around(boxes);
        this.pointArrow(front.clone().addScaledVector(direction, move.out), front, new Vector3(...shown.high).distanceTo(new Vector3(...shown.low)));
        const address = take();
        this.arrow.visible = false;
        return address;
      },
      end: () => {
        only(null);
        this.palette = this.theme.colours();
        Object.assign(this, {share: kept.share, labelled: kept.labelled, view: kept.view});
        Object.assign(this.camera, {zoom: kept.zoom, aspect: kept.aspect, fov: kept.fov});
        this.camera.updateProjectionMatrix();
        this.camera.position.copy(kept.position);
        this.camera.quaternion.copy(kept.quaternion);
        this.camera.updateMatrixWorld(true);
        this.controls.target.copy(kept.target);
        this.renderer.setPixelRatio(kept.ratio);
        this.paint();
        super.resize();
        if (this.last) this.show(...this.last, false);
      },
    };
  }

  /** For tests: the triangles of a part as it stands now, nine numbers each. */
  triangles(part) {
    const {surface, place} = this.shapes[part];
    const transform = new Matrix4().makeTranslation(...this.offsets[part]).multiply(place);
    const points = surface.getAttribute('position');
    const index = surface.getIndex();
    const list = [];
    const point = new Vector3();
    for (let i = 0; i < index.count; ++i) list.push(...point.fromBufferAttribute(points, index.getX(i)).applyMatrix4(transform).toArray());
    return list;
  }
}
