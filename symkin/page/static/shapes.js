// Geometries of links, joints and arrows, as flat lists of triangles with normals. Lengths as they come; no state.
import * as THREE from "three";

const Z = new THREE.Vector3(0, 0, 1);
const Y = new THREE.Vector3(0, 1, 0);

export const vector = (point) => new THREE.Vector3(point[0], point[1], point[2]);

/** The rotation from a unit vector to a direction. */
const turned = (from, way) => new THREE.Quaternion().setFromUnitVectors(from, vector(way).normalize());

/** One geometry of many: positions, normals and triangles of their corners, each of which is drawn once. */
export function merged(geometries) {
  const result = new THREE.BufferGeometry(), triangles = [];
  for (const name of ["position", "normal"])
    result.setAttribute(name, new THREE.Float32BufferAttribute(geometries.flatMap((g) => [...g.attributes[name].array]), 3));
  let before = 0;
  for (const { index, attributes } of geometries) {
    const { count } = attributes.position, corners = index?.array ?? Array(count).keys();
    for (const corner of corners) triangles.push(before + corner);
    before += count;
  }
  return result.setIndex(triangles);
}

/** The same triangles with one corner at each point, whose normal is their sum: shells of it have no gaps. */
export function shellOf(geometry) {
  const { position, normal } = geometry.attributes, corners = new Map(), points = [], ways = [];
  const corner = Array.from({ length: position.count }, (_, k) => {
    const [point, way] = [position, normal].map((attribute) => new THREE.Vector3().fromBufferAttribute(attribute, k));
    const key = point.toArray().map((v) => v.toPrecision(5)).join();
    if (!corners.has(key)) {
      corners.set(key, points.push(point) - 1);
      ways.push(new THREE.Vector3());
    }
    ways[corners.get(key)].add(way);
    return corners.get(key);
  });
  const shell = new THREE.BufferGeometry().setFromPoints(points).setIndex(Array.from(geometry.index.array, (k) => corner[k]));
  return shell.setAttribute("normal", new THREE.Float32BufferAttribute(ways.flatMap((way) => way.toArray()), 3));
}

export function tube(start, end, radius, sides = 14) {
  const a = vector(start), along = vector(end).sub(a), length = along.length();
  const turn = turned(Y, along.toArray()), middle = a.addScaledVector(along, 0.5);
  return new THREE.CylinderGeometry(radius, radius, length, sides).applyQuaternion(turn).translate(middle.x, middle.y, middle.z);
}

export function ball(centre, radius, detail = 18) {
  return new THREE.SphereGeometry(radius, detail, Math.ceil(0.7 * detail)).translate(...centre);
}

export function mark(centre, radius) {
  return new THREE.OctahedronGeometry(radius).translate(...centre);
}

export function block(centre, axis, length, side) {
  return new THREE.BoxGeometry(side, side, length).applyQuaternion(turned(Z, axis)).translate(...centre);
}

/** A thread around a cylinder. */
export function thread(centre, axis, length, radius, wire) {
  const points = [];
  for (let k = 0; k <= 96; k++) {
    const angle = (k / 96) * 8 * Math.PI;
    points.push(new THREE.Vector3(radius * Math.cos(angle), radius * Math.sin(angle), (k / 96 - 0.5) * length));
  }
  return new THREE.TubeGeometry(new THREE.CatmullRomCurve3(points), 96, wire, 6).applyQuaternion(turned(Z, axis)).translate(...centre);
}

export function arrow(start, direction, length, radius) {
  const way = vector(direction).normalize(), a = vector(start);
  const neck = a.clone().addScaledVector(way, Math.max(0, length - 5 * radius));
  const tip = neck.clone().addScaledVector(way, 2.5 * radius);
  const head = new THREE.ConeGeometry(2.4 * radius, 5 * radius, 18).applyQuaternion(turned(Y, direction)).translate(tip.x, tip.y, tip.z);
  return merged([tube(start, neck.toArray(), radius), head]);
}

/** An arrow three quarters around an axis, right-handed. */
export function turnArrow(centre, axis, radius, wire) {
  const sweep = 1.5 * Math.PI;
  const arc = new THREE.TorusGeometry(radius, wire, 10, 48, sweep);
  const head = new THREE.ConeGeometry(2.6 * wire, 6 * wire, 18).translate(0, 3 * wire, 0);
  head.rotateZ(sweep).translate(radius * Math.cos(sweep), radius * Math.sin(sweep), 0);
  return merged([arc, head]).applyQuaternion(turned(Z, axis)).translate(...centre);
}

/** Triangles of flat rings of points, both sides seen by the material. */
export function plates(points, faces) {
  const numbers = [];
  for (const ring of faces) {
    for (let k = 1; k + 1 < ring.length; k++) {
      for (const corner of [ring[0], ring[k], ring[k + 1]]) numbers.push(...points[corner]);
    }
  }
  const result = new THREE.BufferGeometry();
  result.setAttribute("position", new THREE.Float32BufferAttribute(numbers, 3));
  result.computeVertexNormals();
  return result;
}

/** A mesh's triangles, each with its own corners: its places are steps of the box that holds them (`mesh_files.py`). */
export function unpacked(item) {
  const bytes = (text) => Uint8Array.from(atob(text), (c) => c.charCodeAt(0)).buffer;
  const places = new Uint16Array(bytes(item.places));
  const Numbers = places.length / 3 <= 65535 ? Uint16Array : Uint32Array;
  const corners = new Numbers(bytes(item.triangles));
  const numbers = new Float32Array(3 * corners.length);
  corners.forEach((corner, k) => {
    for (let i = 0; i < 3; i++) numbers[3 * k + i] = item.low[i] + (places[3 * corner + i] / 65535) * item.span[i];
  });
  const result = new THREE.BufferGeometry();
  result.setAttribute("position", new THREE.BufferAttribute(numbers, 3));
  result.computeVertexNormals();
  return result;
}
