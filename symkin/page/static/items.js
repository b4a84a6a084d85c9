// The objects of a scene: solids of a link move with its group, those between links are hung or stretched at every pose.
import * as THREE from "three";
import * as shapes from "symkin/shapes";

export class Items {
  constructor(scene, look, linkCount) {
    Object.assign(this, { scene, look });
    this.root = new THREE.Group();
    this.root.scale.setScalar(1 / scene.size);
    this.links = Array.from({ length: linkCount }, () => {
      const group = new THREE.Group();
      group.matrixAutoUpdate = false;
      this.root.add(group);
      return group;
    });
    this.between = []; // {object, ends, hung or apply}: objects that are placed by two points
    this.meshes = []; // what files show of links
    this.solids = []; // what the pointer finds
    for (const item of scene.items) {
      for (const solid of item.solids ?? []) this._solid(solid, item);
      this[`add_${item.kind}`]?.(item);
    }
  }

  /** Move everything to poses (12 numbers a link: rows of [R|t]). */
  place(poses) {
    this.links.forEach((group, k) => {
      group.matrix.set(...poses.subarray(12 * k, 12 * k + 12), 0, 0, 0, 1);
      group.matrixWorldNeedsUpdate = true;
    });
    for (const { object, ends, hung, apply } of this.between) {
      const [a, b] = ends.map((end) => this.at(end));
      if (hung !== undefined) {
        object.matrix.copy(this.links[hung].matrix).setPosition(a.add(b).multiplyScalar(0.5));
        object.matrixWorldNeedsUpdate = true;
        continue;
      }
      const along = b.sub(a), length = along.length();
      object.position.copy(a);
      if (length > 0) object.quaternion.setFromUnitVectors(new THREE.Vector3(0, 0, 1), along.divideScalar(length));
      apply(Math.max(length, 1e-9 * this.scene.size));
    }
  }

  /** Where a point of a link is, in the base frame. */
  at({ link, point }) {
    return shapes.vector(point).applyMatrix4(this.links[link].matrix);
  }

  /** Points of everything that is shown, in the base frame. */
  places() {
    const shown = this.scene.items.filter((item) => item.extent && (item.kind !== "mesh" || this.meshes[0].visible));
    const points = shown.flatMap(({ link, extent }) => extent.map((point) => this.at({ link, point })));
    return points.length ? points : [new THREE.Vector3()];
  }

  /** The parts of one colour of an item, with their contour. */
  _solid({ link, colour, parts, idle, bare, between, stretched, share = 1, most = Infinity }, item) {
    const geometry = shapes.merged(parts.map(([kind, ...numbers]) => shapes[kind](...numbers)));
    const mesh = this._mesh(geometry, this.look.solid(colour), item, between || stretched ? this.root : this.links[link], idle);
    if (!bare) mesh.add(new THREE.Mesh(shapes.shellOf(geometry), this.look.outline));
    if (between) {
      mesh.matrixAutoUpdate = false;
      this.between.push({ object: mesh, ends: between, hung: link });
    }
    if (stretched) this.between.push({ object: mesh, ends: stretched, apply: (length) => (mesh.scale.z = share * Math.min(length, most)) });
  }

  _mesh(geometry, material, item, group, idle = false) {
    const mesh = new THREE.Mesh(geometry, material);
    mesh.userData.item = item;
    if (!idle) this.solids.push(mesh);
    group.add(mesh);
    return mesh;
  }

  /** The plates of a link; dashes along the edges of a base without plates. */
  add_body(item) {
    const { link, points, edges, faces, role, colour } = item, base = role === "base";
    if (faces.length) this._mesh(shapes.plates(points, faces), this.look.glass(colour), item, this.links[link], base);
    else if (base) for (const edge of edges) this._dashes("base edge", (0.3 * this.scene.symbol) / this.scene.size, edge.map((k) => shapes.vector(points[k])));
  }

  add_coupling({ from, to }) {
    const dashes = this._dashes("accent", 0.25 * this.scene.symbol, [new THREE.Vector3(), new THREE.Vector3(0, 0, 1)]);
    const apply = (length) => {
      dashes.geometry.setFromPoints([new THREE.Vector3(), new THREE.Vector3(0, 0, length)]);
      dashes.computeLineDistances();
    };
    this.between.push({ object: dashes, ends: [from, to], apply });
  }

  _dashes(colour, length, points) {
    const line = new THREE.Line(new THREE.BufferGeometry().setFromPoints(points), this.look.dashes(colour, length));
    line.computeLineDistances();
    this.root.add(line);
    return line;
  }

  add_mesh(item) {
    this.meshes.push(this._mesh(shapes.unpacked(item), this.look.shell("base"), item, this.links[item.link]));
  }
}
