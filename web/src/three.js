// The assembly in space, as boxes where parts have positions, as it is where their shapes are known: three draws it. A script of
// its own, which only such reports hold.
import {BoxGeometry, BufferAttribute, BufferGeometry, Color, EdgesGeometry, Group, LineBasicMaterial, LineSegments, Mesh, MeshLambertMaterial, Vector3} from 'three';
import {CSS2DObject} from 'three/addons/renderers/CSS2DRenderer.js';
import {ShapeSpace, readShapes} from './shapes.js';
import {Space, reducedMotion} from './space.js';

const mostLabels = 60;

class AssemblySpace extends Space {
  /** `theme`: {colours, onTheme, pieceColour} of the page. */
  constructor(container, problem, theme) {
    super(container);
    this.theme = theme;
    this.palette = theme.colours();
    this.places = problem.parts.map((part) => new Vector3(...part[3]));
    this.ends = problem.connections.map(([, a, b]) => [a, b]);

    const centre = this.places.reduce((sum, place) => sum.clone().add(place), new Vector3()).divideScalar(this.places.length);
    this.places = this.places.map((place) => place.clone().sub(centre));
    this.radius = Math.max(1e-6, ...this.places.map((place) => place.length()));
    let nearest = Infinity;
    this.places.forEach((place, i) => {
      for (let j = 0; j < i; ++j) {
        const distance = place.distanceTo(this.places[j]);
        if (distance > 1e-9) nearest = Math.min(nearest, distance);
      }
    });
    this.size = Number.isFinite(nearest) ? Math.min(0.62 * nearest, 0.3 * this.radius) : 0.5 * this.radius;
    this.size = Math.max(this.size, 0.035 * this.radius);
    this.radius += this.size;

    this.camera.near = 0.01 * this.radius;
    this.camera.far = 100 * this.radius;
    this.home();

    this.box = new BoxGeometry(this.size, this.size, this.size);
    this.rim = new EdgesGeometry(this.box);
    this.materials = new Map();
    this.parts = problem.parts.map(([ident], part) => {
      const group = new Group();
      const body = new Mesh(this.box);
      const rim = new LineSegments(this.rim);
      group.add(body, rim);
      group.position.copy(this.places[part]);
      const text = document.createElement('span');
      text.textContent = ident;
      const label = new CSS2DObject(text);
      group.add(label);
      this.scene.add(group);
      return {group, body, rim, text, label};
    });
    this.few = this.parts.length <= mostLabels;

    this.lines = new BufferGeometry();
    this.lines.setAttribute('position', new BufferAttribute(new Float32Array(this.ends.length * 6), 3));
    this.lines.setAttribute('color', new BufferAttribute(new Float32Array(this.ends.length * 8), 4));
    this.scene.add(new LineSegments(this.lines, new LineBasicMaterial({vertexColors: true, transparent: true})));

    this.offset = new Vector3();
    theme.onTheme(() => {
      this.palette = theme.colours();
      this.materials.clear();
      if (this.last) this.show(...this.last, false);
    });
    this.resize();
  }

  material(colour, opacity) {
    const key = `${colour} ${opacity}`;
    if (!this.materials.has(key))
      this.materials.set(key, {
        body: new MeshLambertMaterial({color: new Color(colour).lerp(new Color(this.palette.surface), 0.12), transparent: opacity < 1, opacity, depthWrite: opacity === 1}),
        rim: new LineBasicMaterial({color: new Color(colour).lerp(new Color(this.palette.ink), 0.55), transparent: true, opacity: Math.min(1, opacity * 2)}),
      });
    return this.materials.get(key);
  }

  /** The way in which the moved piece leaves, as far as it is drawn apart. */
  way(replay, step) {
    const distance = 2.2 * this.size + 0.12 * this.radius;
    if (step.way) return new Vector3(...step.way[2]).multiplyScalar(distance);
    const middle = (parts) => parts.reduce((sum, part) => sum.add(this.places[part]), new Vector3()).divideScalar(Math.max(1, parts.length));
    const moved = new Set(step.moved);
    const label = step.split?.[0];  // of a fleet, whose steps split several pieces: all that stays
    const kept = replay.plan.labels.map((_, part) => part).filter((part) => !moved.has(part) && (label === undefined || replay.labels[part] === label));
    const away = middle(step.moved).sub(middle(kept));
    if (away.length() < 1e-9) away.set(0, 0, 1);
    away.normalize();
    return away.multiplyScalar(distance);
  }

  show(replay, step, order, animate = true) {
    this.last = [replay, step, order];
    const size = new Map();
    for (const label of replay.labels) size.set(label, (size.get(label) ?? 0) + 1);
    const moved = new Set(step?.moved ?? []);
    this.parts.forEach(({body, rim, text, label}, part) => {
      const single = size.get(replay.labels[part]) === 1;
      const colour = moved.has(part) ? this.palette.accent : this.theme.pieceColour(this.palette, replay.labels[part]);
      const {body: bodyMaterial, rim: rimMaterial} = this.material(colour, single && !moved.has(part) ? 0.14 : 1);
      body.material = bodyMaterial;
      rim.material = rimMaterial;
      text.className = moved.has(part) ? 'space-label moved' : single ? 'space-label single' : 'space-label';
      label.visible = this.few || moved.has(part);
    });
    this.colourLines(replay, step);
    this.moved = [...moved];
    const target = step?.moved ? this.way(replay, step) : new Vector3();
    cancelAnimationFrame(this.frame);
    const [from, to] = order === 'assembly' ? [target, new Vector3()] : [new Vector3(), target];
    this.reset();
    if (!animate || reducedMotion.matches || !step?.moved) {
      this.place(to);
      return;
    }
    const begin = performance.now();
    const tick = (now) => {
      const share = Math.min(1, Math.max(0, (now - begin) / 350));
      const eased = 1 - (1 - share) ** 3;
      this.place(from.clone().lerp(to, eased));
      if (share < 1) this.frame = requestAnimationFrame(tick);
    };
    this.place(from);
    this.frame = requestAnimationFrame(tick);
  }

  reset() {
    this.parts.forEach(({group}, part) => group.position.copy(this.places[part]));
  }

  /** Puts the moved piece this far from its place, and draws. */
  place(offset) {
    for (const part of this.moved) this.parts[part].group.position.copy(this.places[part]).add(offset);
    const position = this.lines.getAttribute('position');
    this.ends.forEach(([a, b], c) => {
      position.setXYZ(2 * c, ...this.parts[a].group.position.toArray());
      position.setXYZ(2 * c + 1, ...this.parts[b].group.position.toArray());
    });
    position.needsUpdate = true;
    this.draw();
  }

  colourLines(replay, step) {
    const attribute = this.lines.getAttribute('color');
    const ink = new Color(this.palette.ink);
    const accent = new Color(this.palette.accent);
    this.ends.forEach((_, c) => {
      const now = step !== undefined && (step.cut?.includes(c) ?? step.c === c);
      const colour = now ? accent : ink;
      const opacity = now ? 1 : replay.present(c) ? 0.75 : 0;
      for (const end of [2 * c, 2 * c + 1]) attribute.setXYZW(end, colour.r, colour.g, colour.b, opacity);
    });
    attribute.needsUpdate = true;
  }

  home() {
    this.camera.position.set(0.75, -1.5, 1).normalize().multiplyScalar(3.6 * this.radius);
    this.camera.lookAt(0, 0, 0);
  }
  zoom(factor) {
    this.camera.position.multiplyScalar(1 / factor);
    this.draw();
  }
  fit() {
    this.home();
    this.controls.update();
    this.draw();
  }
}

globalThis.oraspSpace = (container, problem, theme) => new AssemblySpace(container, problem, theme);
globalThis.oraspShapes = {readShapes, view: (container, problem, plan, shapes, theme) => new ShapeSpace(container, problem, plan, shapes, theme)};
