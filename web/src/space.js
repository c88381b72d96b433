// What drawings in space have in common: a canvas, a layer of labels, a camera that turns around the product, light.
import {DirectionalLight, HemisphereLight, PerspectiveCamera, Scene, WebGLRenderer} from 'three';
import {OrbitControls} from 'three/addons/controls/OrbitControls.js';
import {CSS2DRenderer} from 'three/addons/renderers/CSS2DRenderer.js';

export const reducedMotion = matchMedia('(prefers-reduced-motion: reduce)');

const angle = 35;

export class Space {
  constructor(container) {
    this.container = container;
    this.renderer = new WebGLRenderer({antialias: true, alpha: true, preserveDrawingBuffer: true});
    this.renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
    this.labelRenderer = new CSS2DRenderer();
    this.labelRenderer.domElement.className = 'space-labels';
    this.labelRenderer.domElement.setAttribute('aria-hidden', 'true');
    this.renderer.domElement.className = 'space-canvas';
    this.renderer.domElement.setAttribute('aria-hidden', 'true');
    container.append(this.renderer.domElement, this.labelRenderer.domElement);

    this.scene = new Scene();
    this.scene.add(new HemisphereLight(0xffffff, 0xb0b0b0, 2.6));
    this.sun = new DirectionalLight(0xffffff, 1.6);
    this.sun.position.set(2, -3, 4);
    this.scene.add(this.sun);
    // z is up, as in the problem file.
    this.camera = new PerspectiveCamera(angle, 1, 0.01, 100);
    this.camera.up.set(0, 0, 1);
    this.controls = new OrbitControls(this.camera, this.renderer.domElement);
    this.controls.enableZoom = false;
    this.controls.enablePan = false;
    this.renderer.domElement.style.touchAction = 'pan-y';
    this.controls.addEventListener('change', () => this.draw());
  }

  draw() {
    this.renderer.render(this.scene, this.camera);
    this.labelRenderer.render(this.scene, this.camera);
  }
  picture() {
    this.draw();
    return this.renderer.domElement.toDataURL();
  }
  resize() {
    const {clientWidth: width, clientHeight: height} = this.container;
    if (width === 0 || height === 0) return;
    this.camera.aspect = width / height;
    this.camera.fov = width < height ? angle * Math.min(1.6, height / width) : angle;
    this.camera.updateProjectionMatrix();
    this.renderer.setSize(width, height);
    this.labelRenderer.setSize(width, height);
    this.draw();
  }
}
