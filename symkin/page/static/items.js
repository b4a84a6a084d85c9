// The objects of a scene: those of a link move with its group, rods and rails between links are stretched at every pose.
import * as THREE from "three";
import * as shapes from "symkin/shapes";

const R_WIDTH = 0.26, LINK = 0.13, EDGE = 0.05, ROD = 0.085, FRAME = 1.6;
// radii over the length of a joint's symbol

export function buildItems(scene, look, linkCount) {
  const made = new Items(scene, look, linkCount);
  for (const item of scene.items) made[`add_${item.kind}`]?.(item);
  return made;
}

class Items {
  constructor(scene, look, linkCount) {
    this.scene = scene;
    this.look = look;
    this.symbol = scene.symbol;
    this.root = new THREE.Group();
    this.root.scale.setScalar(1 / scene.size);
    this.links = Array.from({ length: linkCount }, () => {
      const group = new THREE.Group();
      group.matrixAutoUpdate = false;
      this.root.add(group);
      return group;
    });
    this.stretched = []; // {object, from, to, apply}
    this.middles = []; // objects turned with a link, halfway between two points
    this.meshes = []; // what files show of links
    this.solids = []; // what the pointer finds
    this.labels = []; // {item, at: [{link, point}, ...]}
  }

  /** Move everything to poses (12 numbers a link: rows of [R|t]). */
  place(poses) {
    this.links.forEach((group, k) => {
      group.matrix.set(...poses.subarray(12 * k, 12 * k + 12), 0, 0, 0, 1);
      group.matrixWorldNeedsUpdate = true;
    });
    for (const { group, link, ends } of this.middles) {
      const [a, b] = ends.map((end) => this.at(end));
      group.matrix.copy(this.links[link].matrix).setPosition(a.add(b).multiplyScalar(0.5));
      group.matrixWorldNeedsUpdate = true;
    }
    for (const { object, from, to, apply } of this.stretched) {
      const a = this.at(from), b = this.at(to), along = b.clone().sub(a), length = along.length();
      object.position.copy(a);
      if (length > 0) object.quaternion.setFromUnitVectors(new THREE.Vector3(0, 0, 1), along.divideScalar(length));
      apply(Math.max(length, 1e-9 * this.scene.size));
    }
  }

  /** Where a point of a link is, in the base frame. */
  at({ link, point }) {
    return shapes.vector(point).applyMatrix4(this.links[link].matrix);
  }

  /** Points of everything, in the base frame. */
  places() {
    const bodies = this.scene.items.filter((item) => item.kind === "body");
    const points = bodies.flatMap((item) => item.points.map((point) => this.at({ link: item.link, point })));
    const frames = this.scene.items.filter((item) => item.kind === "frame");
    points.push(...frames.flatMap((item) => this._axisEnds(item).map((point) => this.at({ link: item.link, point }))));
    for (const { visible, userData } of this.meshes) {
      if (visible) points.push(...boxCorners(userData.item).map((point) => this.at({ link: userData.item.link, point })));
    }
    return points.length ? points : [new THREE.Vector3()];
  }

  // --- links -----------------------------------------------------------------------------------------------------

  add_body(item) {
    const { points, edges, faces, role } = item, s = this.symbol, base = role === "base";
    const group = this.links[item.link];
    if (faces.length) {
      const plate = new THREE.Mesh(shapes.plates(points, faces), this.look.glass(item.colour));
      plate.userData.item = item;
      group.add(plate);
      if (!base) this.solids.push(plate);
    }
    if (base && !faces.length) this._baseLines(item);
    const rim = new Set(faces.flat()), onRim = (k) => !faces.length || rim.has(k);
    const radius = s * (base ? EDGE : role === "platform" ? 1.15 * LINK : LINK);
    const tubes = base && !faces.length ? [] : edges.map(([a, b]) => shapes.tube(points[a], points[b], onRim(a) && onRim(b) ? radius : 0.45 * radius));
    const knots = tubes.length ? points.map((p, k) => shapes.ball(p, onRim(k) ? radius : 0.45 * radius, 12)) : [];
    if (tubes.length) this._solid(group, shapes.merged([...tubes, ...knots]), item.colour, item);
    if (base) points.forEach((p) => this._ground(p));
    const centre = [0, 1, 2].map((k) => points.reduce((sum, p) => sum + p[k], 0) / points.length);
    this.labels.push({ item, at: [{ link: item.link, point: points.length === 2 ? middle(points) : centre }] });
  }

  _baseLines(item) {
    for (const [a, b] of item.edges) {
      const geometry = new THREE.BufferGeometry().setFromPoints([shapes.vector(item.points[a]), shapes.vector(item.points[b])]);
      const line = new THREE.Line(geometry, this.look.dashes("base edge", 0.3 * this.symbol / this.scene.size));
      line.computeLineDistances();
      this.root.add(line);
    }
  }

  /** The sign of the fixed link below a point: a bar with hatches in a planar mechanism, a foot in others. */
  _ground(point) {
    const { right, up, planar, towards } = this.scene.view, s = this.symbol;
    const moved = (x, y) => point.map((v, k) => v + s * (x * right[k] + y * up[k]));
    if (!planar) {
      const down = [0, 0, -1];
      this._solid(this.links[0], shapes.drum(point.map((v, k) => v + 0.3 * s * down[k]), down, 0.14 * s, 0.42 * s), "base");
      return;
    }
    const bars = [shapes.tube(moved(-0.75, -0.5), moved(0.75, -0.5), 0.045 * s, 8)];
    for (let k = 0; k < 6; k++) bars.push(shapes.tube(moved(-0.65 + 0.26 * k, -0.5), moved(-0.85 + 0.26 * k, -0.75), 0.025 * s, 6));
    bars.push(shapes.tube(moved(0, 0), moved(-0.42, -0.5), 0.04 * s, 8), shapes.tube(moved(0, 0), moved(0.42, -0.5), 0.04 * s, 8));
    const mesh = new THREE.Mesh(shapes.merged(bars), this.look.solid("base edge"));
    mesh.userData.behind = towards;
    this.links[0].add(mesh);
  }

  // --- joints ----------------------------------------------------------------------------------------------------

  add_joint(item) {
    const [before, after] = item.links.map((k) => this.links[k]);
    const fill = item.actuated ? "accent" : "white", s = this.symbol, [axis, axis2] = item.axes, p = item.point;
    const hold = item.slides ? after : before;
    if (["R", "H", "C"].includes(item.type)) this._solid(hold, shapes.drum(p, axis, s, R_WIDTH * s), fill, item);
    switch (item.type) {
      case "R":
        break; // the drum alone
      case "H":
        this._solid(hold, shapes.thread(p, axis, 0.85 * s, R_WIDTH * s, 0.035 * s), "link", item);
        break;
      case "C":
        this._solid(hold, shapes.drum(p, axis, 2.2 * s, 0.08 * s, 12), "link", item);
        break;
      case "P":
        this._slide(item, fill);
        break;
      case "U":
        this._cross(before, p, axis, fill, item);
        this._cross(after, p, axis2, fill, item);
        break;
      case "S":
        this._solid(after, shapes.ball(p, 0.26 * s), fill, item);
        break;
      default:
        this._solid(after, shapes.block(p, [0, 0, 1], 0.36 * s, 0.36 * s), "link", item);
    }
    if (item.slides) this._rail(item);
    const ends = endsOf(item);
    this.labels.push({ item, at: item.type === "P" ? ends : [ends[1]] });
  }

  _cross(group, centre, axis, fill, item) {
    const s = this.symbol, way = shapes.vector(axis).normalize(), c = shapes.vector(centre);
    const ends = [1, -1].map((sign) => c.clone().addScaledVector(way, sign * 0.46 * s).toArray());
    this._solid(group, shapes.merged([shapes.drum(centre, axis, 0.92 * s, 0.09 * s, 14), shapes.ball(centre, 0.2 * s)]), fill, item);
    this._solid(group, shapes.merged(ends.map((end) => shapes.drum(end, axis, 0.12 * s, 0.17 * s, 18))), "link", item);
  }

  _rail(item) {
    const object = new THREE.Mesh(shapes.unitRod(0.07 * this.symbol), this.look.solid("link"));
    this.root.add(object);
    const [from, to] = endsOf(item);
    this.stretched.push({ object, from, to, apply: (length) => (object.scale.z = length) });
  }

  /** A prism in the middle of its rail. */
  _slide(item, fill) {
    const [before] = item.links, s = this.symbol, [axis] = item.axes, group = new THREE.Group();
    group.matrixAutoUpdate = false;
    this._solid(group, shapes.block([0, 0, 0], axis, s, 2 * R_WIDTH * s), fill, item);
    this._solid(group, shapes.drum([0, 0, 0], axis, 1.7 * s, 0.07 * s, 12), "link", item);
    this.root.add(group);
    this.middles.push({ group, link: before, ends: endsOf(item) });
  }

  add_rod(item) {
    const s = this.symbol, object = new THREE.Group();
    const shaft = this._solid(object, shapes.unitRod(ROD * s), "link", item);
    const rest = Math.hypot(...item.to.point.map((v, k) => v - item.from.point[k]));
    const barrel = item.actuated ? this._solid(object, shapes.unitRod(2.0 * ROD * s), "accent", item) : null;
    const stretch = (solid, length) => solid.children.concat(solid).forEach((m) => m === solid && (m.scale.z = length));
    this.root.add(object);
    this.stretched.push({
      object, from: item.from, to: item.to,
      apply: (length) => {
        stretch(shaft, length);
        if (barrel) stretch(barrel, 0.52 * Math.min(length, Math.max(rest, 0.3 * this.scene.size)));
      },
    });
    for (const end of [item.from, item.to]) this._solid(this.links[end.link], shapes.ball(end.point, 0.2 * s), "white", item);
    this.labels.push({ item, at: [item.from, item.to] });
  }

  add_coupling(item) {
    const line = new THREE.Line(new THREE.BufferGeometry(), this.look.dashes("accent", 0.25 * this.symbol));
    line.geometry.setFromPoints([new THREE.Vector3(), new THREE.Vector3(0, 0, 1)]);
    this.root.add(line);
    this.stretched.push({
      object: line, from: item.from, to: item.to,
      apply: (length) => {
        line.geometry.setFromPoints([new THREE.Vector3(), new THREE.Vector3(0, 0, length)]);
        line.computeLineDistances();
      },
    });
  }

  // --- points, frames, meshes ------------------------------------------------------------------------------------

  add_point(item) {
    const mark = new THREE.OctahedronGeometry(0.22 * this.symbol).translate(...item.point);
    this._solid(this.links[item.link], mark, "text", item);
    this.labels.push({ item, at: [{ link: item.link, point: item.point }] });
  }

  _axisEnds({ position, rotation }) {
    const along = [0, 1, 2].map((k) => position.map((v, r) => v + FRAME * this.symbol * rotation[r][k]));
    return [position, ...along];
  }

  add_frame(item) {
    const group = this.links[item.link];
    "xyz".split("").forEach((name, k) => {
      const way = item.rotation.map((row) => row[k]);
      const mesh = new THREE.Mesh(shapes.arrow(item.position, way, FRAME * this.symbol, 0.045 * this.symbol), this.look.solid(`frame ${name}`));
      mesh.userData.item = item;
      group.add(mesh);
    });
  }

  add_mesh(item) {
    const geometry = shapes.unpacked(item);
    const mesh = new THREE.Mesh(geometry, this.look.shell("base"));
    mesh.userData.item = item;
    this.links[item.link].add(mesh);
    this.meshes.push(mesh);
    this.solids.push(mesh);
  }

  /** A solid with its contour. */
  _solid(group, geometry, colour, item) {
    const mesh = new THREE.Mesh(geometry, this.look.solid(colour));
    mesh.add(new THREE.Mesh(shapes.shellOf(geometry), this.look.outline));
    if (item) {
      mesh.userData.item = item;
      this.solids.push(mesh);
    }
    group.add(mesh);
    return mesh;
  }
}

/** The points of a joint on the links before and after it. */
function endsOf({ start, point, links }) {
  return [start, point].map((place, k) => ({ link: links[k], point: place }));
}

function middle([a, b]) {
  return a.map((v, k) => 0.5 * (v + b[k]));
}

/** Corners of the box that holds a mesh, in its link's frame. */
function boxCorners({ low, span }) {
  return [...Array(8).keys()].map((k) => low.map((v, i) => v + ((k >> i) & 1) * span[i]));
}
