// What is drawn, the light on it, and the camera.

import {
  AmbientLight, Box3, BufferAttribute, DirectionalLight, DoubleSide, Group, Mesh, MeshBasicMaterial, MeshLambertMaterial,
  PerspectiveCamera, Raycaster, Scene, Vector2, Vector3, WebGLRenderer,
} from 'three';
import { OrbitControls } from 'three/addons/controls/OrbitControls.js';

// Degrees from the upper to the lower rim of the canvas, and how much of it a mesh fills at first.
const FIELD = 35;
const ROOM = 0.94;

export class Stage {
  constructor(canvas, mesh) {
    this.canvas = canvas;
    this.mesh = mesh;
    // What lies behind it is the page's ground, light or dark; what was drawn stays for printing.
    this.renderer = new WebGLRenderer({ canvas, antialias: true, alpha: true, preserveDrawingBuffer: true });
    this.surface = new MeshLambertMaterial({ flatShading: true, side: DoubleSide, polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 1 });
    this.edge = new MeshBasicMaterial({ wireframe: true, color: 0x101418, transparent: true, opacity: 0.45 });
    this.ground = new Group();
    this.edges = new Group();
    this.edges.visible = false;
    const box = new Box3();
    for (const geometry of mesh.geometries) {
      geometry.computeBoundingBox();
      box.union(geometry.boundingBox);
      this.ground.add(new Mesh(geometry, this.surface));
      this.edges.add(new Mesh(geometry, this.edge));
    }
    this.middle = box.getCenter(new Vector3());
    this.size = box.getSize(new Vector3());
    this.extent = Math.hypot(this.size.x, this.size.z) || 1;
    this.scene = new Scene();
    const sun = new DirectionalLight(0xffffff, 2.6);
    // From the upper left of a map, as on paper.
    sun.position.set(-1, 1.1, -1);
    this.whole = new Group().add(this.ground, this.edges);
    this.scene.add(new AmbientLight(0xffffff, 1.1), sun, this.whole);
    this.camera = new PerspectiveCamera(FIELD, 2, this.extent / 2000, this.extent * 20);
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.screenSpacePanning = false;
    this.controls.zoomToCursor = true;
    this.controls.minDistance = this.extent / 500;
    this.controls.maxDistance = this.extent * 8;
    this.controls.listenToKeyEvents(canvas);
    // The wheel moves the page until somebody has taken hold of the view.
    this.controls.enableZoom = false;
    canvas.addEventListener('pointerdown', () => canvas.focus({ preventScroll: true }));
    canvas.addEventListener('focus', () => { this.controls.enableZoom = true; });
    canvas.addEventListener('blur', () => { this.controls.enableZoom = false; });
    this.controls.addEventListener('change', () => this.draw());
    this.rays = new Raycaster();
    new ResizeObserver(() => this.fit()).observe(canvas);
    this.fit();
  }

  fit() {
    const { clientWidth: width, clientHeight: height } = this.canvas;
    if (width === 0 || height === 0) return;
    this.renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    this.draw();
  }

  draw() {
    this.renderer.render(this.scene, this.camera);
  }

  // Colours of vertices, or an image over samples; nothing for grey.
  paint({ colours, image, at }) {
    this.mesh.geometries.forEach((geometry, i) => {
      if (colours) geometry.setAttribute('color', new BufferAttribute(colours[i], 3));
      if (image && !geometry.hasAttribute('uv')) geometry.setAttribute('uv', this.places(geometry, at));
    });
    this.surface.map?.dispose();
    this.surface.map = image ?? null;
    this.surface.vertexColors = Boolean(colours);
    this.surface.color.set(colours || image ? 0xffffff : 0xb9bec4);
    this.surface.needsUpdate = true;
    this.draw();
  }

  // Where vertices lie in an image of `size` squares of samples.
  places(geometry, { columns, rows, size }) {
    const positions = geometry.getAttribute('position'), vertex = new Vector3();
    const uv = new Float32Array(2 * positions.count);
    for (let i = 0; i < positions.count; i++) {
      const [x, y] = this.mesh.frame.toMap(vertex.fromBufferAttribute(positions, i));
      uv[2 * i] = (columns[0] + columns[1] * x + columns[2] * y + 0.5) / size[0];
      uv[2 * i + 1] = (rows[0] + rows[1] * x + rows[2] * y + 0.5) / size[1];
    }
    return new BufferAttribute(uv, 2);
  }

  // Heights times a factor, about the middle.
  stretch(factor) {
    this.whole.scale.y = factor;
    this.whole.position.y = this.middle.y * (1 - factor);
    this.draw();
  }

  showEdges(visible) {
    this.edges.visible = visible;
    this.draw();
  }

  lookFromAbove() {
    this.look(new Vector3(0, 1, 1e-6));
  }

  lookAslant() {
    this.look(new Vector3(-0.3, 0.6, 1));
  }

  // From a direction, as near as all of the mesh is seen, and with it in the middle of the canvas.
  look(direction) {
    const target = this.controls.target.copy(this.middle);
    direction.normalize();
    const from = distance => {
      this.camera.position.copy(target).addScaledVector(direction, distance);
      this.camera.lookAt(target);
      this.camera.updateMatrixWorld();
      return this.corners().map(corner => corner.project(this.camera));
    };
    const isSeen = ({ x, y, z }) => Math.max(Math.abs(x), Math.abs(y)) <= ROOM && z < 1;
    for (let round = 0; round < 6; round++) {
      let [near, far] = [0, this.controls.maxDistance];
      for (let step = 0; step < 30; step++) {
        const between = (near + far) / 2;
        if (from(between).every(isSeen)) far = between;
        else near = between;
      }
      const places = from(far), up = Math.tan((FIELD * Math.PI) / 360) * far;
      const middle = axis => (Math.min(...places.map(place => place[axis])) + Math.max(...places.map(place => place[axis]))) / 2;
      const along = (column, length) => new Vector3().setFromMatrixColumn(this.camera.matrixWorld, column).multiplyScalar(length);
      if (round < 5) target.add(along(0, middle('x') * up * this.camera.aspect)).add(along(1, middle('y') * up));
    }
    this.controls.update();
    this.draw();
  }

  // Those of a box around what is drawn.
  corners() {
    const half = this.size.clone().multiplyScalar(0.5);
    half.y *= this.whole.scale.y;
    return [0, 1, 2, 3, 4, 5, 6, 7].map(bits =>
      new Vector3(bits & 1 ? 1 : -1, bits & 2 ? 1 : -1, bits & 4 ? 1 : -1).multiply(half).add(this.middle));
  }

  // The place of the mesh at a place of the canvas, from -1 to 1 each way; nothing where there is no mesh.
  at(x, y) {
    this.rays.setFromCamera(new Vector2(x, y), this.camera);
    const [hit] = this.rays.intersectObject(this.ground, true);
    return hit && this.whole.worldToLocal(hit.point.clone());
  }
}
