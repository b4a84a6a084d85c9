// The 3-D view: camera, light, grid, arrows at a stop, traces; drawn only when something changed.
import * as THREE from "three";
import { OrbitControls } from "OrbitControls";
import { Items } from "symkin/items";
import { Look } from "symkin/look";
import * as shapes from "symkin/shapes";

const MARGIN = 1.25; // of the picture over what it holds

export class Drawing {
  constructor(canvas, scene, linkCount) {
    this.canvas = canvas;
    this.scene = scene;
    this.look = new Look(scene.colours);
    this.renderer = new THREE.WebGLRenderer({ canvas, antialias: true, alpha: true });
    this.renderer.setPixelRatio(Math.min(window.devicePixelRatio || 1, 2));
    this.world = new THREE.Scene();
    this.items = new Items(scene, this.look, linkCount);
    this.world.add(this.items.root);
    this.extras = new THREE.Group();
    this.items.root.add(this.extras);
    this._camera();
    this._lights();
    this._grid();
    this.camera.lookAt(0, 0, 0);
    this.dirty = true;
    this.listeners = [];
  }

  _camera() {
    const { up, towards, planar } = this.scene.view;
    this.camera = new THREE.OrthographicCamera(-1, 1, 1, -1, -50, 50);
    this.camera.up.set(...(planar ? up : [0, 0, 1]));
    this.camera.position.set(...towards).multiplyScalar(5);
    this.controls = new OrbitControls(this.camera, this.canvas);
    this.controls.enableDamping = true;
    this.controls.dampingFactor = 0.12;
    this.controls.zoomSpeed = 1.4;
    this.controls.keyPanSpeed = 20;
    this.controls.listenToKeyEvents(this.canvas);
    this.controls.addEventListener("change", () => (this.dirty = true));
  }

  _lights() {
    this.world.add(new THREE.HemisphereLight("#ffffff", "#c3ccd6", 2.2));
    const lamp = new THREE.DirectionalLight("#ffffff", 1.3);
    lamp.position.set(-0.6, 1.2, 2.0);
    this.camera.add(lamp);
    this.world.add(this.camera);
  }

  _grid() {
    const lines = new THREE.BufferGeometry().setFromPoints(this.scene.grid.map(shapes.vector));
    this.grid = new THREE.LineSegments(lines, this.look.backdrop("grid"));
    this.grid.renderOrder = -1;
    this.items.root.add(this.grid);
  }

  place(poses) {
    this.poses = poses;
    this.items.place(poses);
    this.dirty = true;
  }

  /** The box along the camera's axes that holds what is drawn at some configurations. */
  boxOf(manyPoses) {
    const box = new THREE.Box3(), here = this.poses;
    this.camera.updateMatrixWorld();
    for (const poses of manyPoses) {
      this.items.place(poses);
      for (const p of this.items.places()) box.expandByPoint(p.divideScalar(this.scene.size).applyMatrix4(this.camera.matrixWorldInverse));
    }
    this.items.place(here);
    return box;
  }

  /** Bring everything that is drawn into the picture. */
  fit() {
    const seen = this.boxOf([this.poses]), offset = this.camera.position.clone().sub(this.controls.target).setLength(5);
    const centre = seen.getCenter(new THREE.Vector3()).applyMatrix4(this.camera.matrixWorld);
    this.controls.target.copy(centre);
    this.camera.position.copy(centre).add(offset);
    this.camera.zoom = 1;
    this.camera.updateMatrixWorld();
    const pad = (1.5 * this.scene.symbol) / this.scene.size;
    this.half = [0.5 * (seen.max.x - seen.min.x) + pad, 0.5 * (seen.max.y - seen.min.y) + pad];
    this.resize();
  }

  resize() {
    const { clientWidth: width, clientHeight: height } = this.canvas.parentElement;
    if (!width || !height) return;
    this.width = width;
    this.height = height;
    this.renderer.setSize(width, height, false);
    const aspect = width / height, half = MARGIN * Math.max(this.half[1], this.half[0] / aspect, 0.2);
    Object.assign(this.camera, { left: -half * aspect, right: half * aspect, top: half, bottom: -half });
    this.camera.updateProjectionMatrix();
    this.look.setContours(width, height);
    this.dirty = true;
  }

  setMeshes(shown) {
    for (const mesh of this.items.meshes) mesh.visible = shown;
    this.dirty = true;
  }

  setDark(dark) {
    this.look.setDark(dark);
    this.dirty = true;
  }

  /** Draw if something changed; whether it did. */
  render() {
    this.controls.update();
    if (!this.dirty) return false;
    this.dirty = false;
    this.renderer.render(this.world, this.camera);
    this.listeners.forEach((listener) => listener());
    return true;
  }

  // --- small views -------------------------------------------------------------------------------------------------

  /** Draw configurations into small canvases, seen as the large view is, until a time is over; how many of `jobs` ([canvas, poses]) were
   * drawn. All that is in `box` is in each picture. The large view is drawn anew after them. */
  drawSmall(jobs, box, until) {
    const { items, renderer, poses: here } = this, hidden = [this.grid, this.extras, ...items.meshes].filter((object) => object.visible);
    for (const object of hidden) object.visible = false;
    renderer.setScissorTest(true);
    let drawn = 0;
    for (const [canvas, poses] of jobs) {
      if (drawn && performance.now() > until) break;
      items.place(poses);
      this._drawSmall(canvas, box);
      drawn += 1;
    }
    for (const object of hidden) object.visible = true;
    renderer.setScissorTest(false);
    renderer.setViewport(0, 0, this.width, this.height);
    this.look.setContours(this.width, this.height);
    this.place(here);
    return drawn;
  }

  /** Draw what stands in the scene in a corner of the large canvas, and copy it. */
  _drawSmall(canvas, box) {
    const { renderer } = this, { clientWidth: width, clientHeight: height } = canvas, ratio = renderer.getPixelRatio();
    const camera = this.camera.clone(false), middle = box.getCenter(new THREE.Vector3()), span = box.getSize(new THREE.Vector3());
    const scale = (0.5 / 0.86) * Math.max(span.x / width, span.y / height, 0.2 / height);
    Object.assign(camera, { left: middle.x - scale * width, right: middle.x + scale * width, zoom: 1 });
    Object.assign(camera, { bottom: middle.y - scale * height, top: middle.y + scale * height });
    camera.updateProjectionMatrix();
    this.look.setContours(width, height, 0.4);
    renderer.setViewport(0, 0, width, height);
    renderer.setScissor(0, 0, width, height);
    renderer.render(this.world, camera);
    Object.assign(canvas, { width: width * ratio, height: height * ratio });
    const place = [0, renderer.domElement.height - canvas.height, canvas.width, canvas.height];
    canvas.getContext("2d").drawImage(renderer.domElement, ...place, 0, 0, canvas.width, canvas.height);
  }

  /** Where a point of the base frame is on the screen, in pixels of the picture. */
  onScreen(point) {
    const p = (point.isVector3 ? point.clone() : shapes.vector(point)).divideScalar(this.scene.size).project(this.camera);
    return [0.5 * (p.x + 1) * this.width, 0.5 * (1 - p.y) * this.height, p.z];
  }

  /** Lengths of the mechanism that one pixel shows. */
  get lengthOfPixel() {
    return ((this.camera.right - this.camera.left) / this.camera.zoom / this.width) * this.scene.size;
  }

  /** Directions right, up and towards the eye, in the base frame. */
  get axes() {
    const rows = [0, 1, 2].map((k) => new THREE.Vector3().setFromMatrixColumn(this.camera.matrixWorld, k));
    return rows.map((row) => row.toArray());
  }

  /** The item under a place of the picture, null where there is none. */
  itemAt(x, y) {
    const ray = new THREE.Raycaster();
    ray.setFromCamera(new THREE.Vector2((2 * x) / this.width - 1, 1 - (2 * y) / this.height), this.camera);
    const hits = ray.intersectObjects(this.items.solids, false);
    // joints stand out of the plates of their links
    const joint = hits.find((hit) => ["joint", "rod", "point"].includes(hit.object.userData.item.kind));
    const first = hits[0];
    const near = joint && joint.distance - first.distance < (1.5 * this.scene.symbol) / this.scene.size;
    return (near ? joint : first)?.object.userData.item ?? null;
  }

  // --- arrows and traces -----------------------------------------------------------------------------------------

  clearExtras(kind) {
    for (const object of [...this.extras.children]) {
      if (object.userData.kind === kind) {
        this.extras.remove(object);
        object.geometry.dispose();
      }
    }
    this.dirty = true;
  }

  /** Show a twist (velocity of `at`, angular velocity) as arrows: about its axis, and along it or, of a translation, along that. */
  showTwist(twist, at, colour = "loop") {
    this.clearExtras("twist");
    const v = new THREE.Vector3(...twist.slice(0, 3)), w = new THREE.Vector3(...twist.slice(3)), size = this.scene.size;
    const turning = w.length() * size, sliding = v.length(), wire = 0.12 * this.scene.symbol;
    if (turning > 1e-3 * sliding) {
      const foot = new THREE.Vector3().crossVectors(w, v).divideScalar(w.lengthSq());
      if (foot.length() < 1.2 * size) {
        const centre = foot.add(shapes.vector(at)), half = w.clone().setLength(0.35 * size);
        const ends = [-1, 1].map((sign) => centre.clone().addScaledVector(half, sign).toArray());
        this._extra(shapes.turnArrow(centre.toArray(), w.toArray(), 0.22 * size, wire), colour, "twist");
        this._extra(shapes.tube(...ends, 0.3 * wire, 28), colour, "twist");
        return;
      }
    }
    if (sliding > 0) this._extra(shapes.arrow(at, v.toArray(), 0.35 * size, wire), colour, "twist");
  }

  /** Show lines through points (k, 3) of the base frame. */
  showTrace(points, colour, kind = "trace") {
    if (points.length < 2) return;
    const geometry = new THREE.BufferGeometry().setFromPoints(points.map((p) => (p.isVector3 ? p : shapes.vector(p))));
    const line = new THREE.Line(geometry, this.look.line(colour));
    line.userData.kind = kind;
    this.extras.add(line);
    this.dirty = true;
  }

  _extra(geometry, colour, kind) {
    const mesh = new THREE.Mesh(geometry, this.look.solid(colour));
    mesh.add(new THREE.Mesh(shapes.shellOf(geometry), this.look.outline));
    mesh.userData.kind = kind;
    this.extras.add(mesh);
    this.dirty = true;
  }
}

/** The nearest of 1, 2, 5 times a power of ten. */
export function roundLength(length) {
  const power = 10 ** Math.floor(Math.log10(length)), share = length / power;
  return power * (share < 1.5 ? 1 : share < 3.5 ? 2 : share < 7.5 ? 5 : 10);
}
