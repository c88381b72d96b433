// Buttons, slider, speed and order; play by requestAnimationFrame.
import {h} from './dom.js';

const icons = {
  first: 'M4 3v12M15 3 6 9l9 6z',
  back: 'M12 3 5 9l7 6z',
  play: 'M5 3l10 6-10 6z',
  pause: 'M5 3v12M12 3v12',
  next: 'M6 3l7 6-7 6z',
  last: 'M14 3v12M3 3l9 6-9 6z',
};

function icon(name) {
  const ns = 'http://www.w3.org/2000/svg';
  const svg = document.createElementNS(ns, 'svg');
  svg.setAttribute('viewBox', '0 0 18 18');
  svg.setAttribute('aria-hidden', 'true');
  const path = document.createElementNS(ns, 'path');
  path.setAttribute('d', icons[name]);
  svg.append(path);
  return svg;
}

export class Player {
  /** `describe()` says where `position` is, for the slider. */
  constructor(position, describe) {
    this.position = position;
    this.describe = describe;
    const n = position.length;
    const button = (name, label, action) => {
      const element = h('button', {type: 'button', class: 'icon', 'aria-label': label, title: label, onclick: action});
      element.append(icon(name));
      return element;
    };
    this.first = button('first', 'To the start', () => this.go(0));
    this.back = button('back', 'Step back', () => this.go(position.place - 1));
    this.playButton = button('play', 'Play', () => this.toggle());
    this.next = button('next', 'Step forward', () => this.go(position.place + 1));
    this.last = button('last', 'To the end', () => this.go(n));
    this.slider = h('input', {type: 'range', id: 'place', min: 0, max: n, step: 1, value: 0, 'aria-label': 'Step', oninput: () => this.go(Number(this.slider.value))});
    this.label = h('span', {class: 'place', 'aria-hidden': 'true'});
    const usual = [1, 2, 5, 10, 20].find((speed) => n / speed <= 45) ?? 20;
    this.speed = h('select', {id: 'speed', 'aria-label': 'Speed, steps a second', onchange: () => this.again()},
      [0.5, 1, 2, 5, 10, 20].map((speed) => h('option', {value: speed, selected: speed === usual}, `${speed}/s`)));
    const order = (name) => h('label', {}, h('input', {type: 'radio', name: 'order', value: name, checked: position.order === name, onchange: () => this.setOrder(name)}), h('span', {}, name === 'assembly' ? 'Assembly' : 'Disassembly'));
    // Who chose by pointer has the arrow keys for the steps again; who came by keyboard chooses with them.
    const chosen = (event) => event.detail > 0 && document.activeElement?.blur();
    this.element = h('div', {class: 'player', role: 'group', 'aria-label': 'Steps'},
      h('div', {class: 'buttons'}, this.first, this.back, this.playButton, this.next, this.last),
      h('div', {class: 'slide'}, this.slider, this.label),
      h('fieldset', {class: 'order', onclick: chosen}, h('legend', {class: 'unseen'}, 'Order'), order('disassembly'), order('assembly')),
      h('label', {class: 'speed'}, h('span', {class: 'speed-name'}, 'Speed '), this.speed));
    this.playing = false;
    position.onChange(() => this.update());
    document.addEventListener('keydown', (event) => this.key(event));
    this.update();
  }

  go(place) {
    this.stop();
    this.position.set(place);
  }

  /** The other order, at the same state of the product. */
  setOrder(order) {
    this.stop();
    const {position} = this;
    if (order !== position.order) position.set(position.length - position.place, order);
  }

  toggle() {
    if (this.playing) this.stop();
    else this.start();
  }
  start() {
    if (this.position.length === 0) return;
    if (this.position.place === this.position.length) this.position.set(0);
    this.playing = true;
    this.due = performance.now() + this.pause();
    this.frame = requestAnimationFrame((now) => this.tick(now));
    this.update();
  }
  stop() {
    if (!this.playing) return;
    this.playing = false;
    cancelAnimationFrame(this.frame);
    this.update();
  }
  again() {
    this.due = performance.now() + this.pause();
  }
  pause() {
    return 1000 / Number(this.speed.value);
  }
  tick(now) {
    if (now >= this.due) {
      this.due = Math.max(this.due + this.pause(), now);
      this.position.set(this.position.place + 1);
      if (this.position.place === this.position.length) {
        this.stop();
        return;
      }
    }
    this.frame = requestAnimationFrame((later) => this.tick(later));
  }

  key(event) {
    if (document.documentElement.dataset.view || event.defaultPrevented || event.ctrlKey || event.altKey || event.metaKey || event.shiftKey) return;
    const {target} = event;
    if (target !== this.slider && target.matches?.('input, select, textarea, [data-scrolls]')) return;
    const actions = {
      ArrowRight: () => this.go(this.position.place + 1),
      ArrowLeft: () => this.go(this.position.place - 1),
      Home: () => this.go(0),
      End: () => this.go(this.position.length),
    };
    // Space presses the button that has the focus; elsewhere it plays.
    if (event.key === ' ' && (target === this.slider || target === document.body)) actions[' '] = () => this.toggle();
    const action = actions[event.key];
    if (!action) return;
    event.preventDefault();
    action();
  }

  update() {
    const {place, length} = this.position;
    this.slider.value = String(place);
    this.slider.setAttribute('aria-valuetext', this.describe());
    this.label.textContent = `${place} / ${length}`;
    // A button that is at its end stays focusable, so that the keyboard does not lose its place.
    for (const button of [this.first, this.back]) button.setAttribute('aria-disabled', String(place === 0));
    for (const button of [this.next, this.last]) button.setAttribute('aria-disabled', String(place === length));
    const name = this.playing ? 'pause' : 'play';
    if (this.playButton.dataset.icon !== name) {
      this.playButton.dataset.icon = name;
      this.playButton.replaceChildren(icon(name));
      this.playButton.setAttribute('aria-label', this.playing ? 'Pause' : 'Play');
      this.playButton.title = this.playing ? 'Pause' : 'Play';
    }
    for (const radio of this.element.querySelectorAll('input[name=order]')) radio.checked = radio.value === this.position.order;
  }
}
