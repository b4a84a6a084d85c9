// Where links are, and what joints read that the closure leaves out.
// A link's frame is the base frame at the reference, so that its pose is its displacement from there.

/** Poses of all links: `quaternions` and `positions` by number, and `matrices` with 12 numbers each. */
export function placedLinks(model, functions, x) {
  const count = model.links.length, packed = new Float64Array(7 * count);
  functions.links(x, packed);
  const poses = Array.from({ length: count }, (_, k) => ({ t: [...packed.subarray(7 * k, 7 * k + 3)], q: unit([...packed.subarray(7 * k + 3, 7 * k + 7)]) }));
  for (const bridge of model.bridges) hang(bridge, poses);
  const matrices = new Float64Array(12 * count);
  poses.forEach((pose, k) => matrices.set(rows(pose), 12 * k));
  return { poses, matrices };
}

/** Links between two spherical joints: turned about the first centre by the shortest way, so that both ends meet. */
function hang({ links, ends, centres }, poses) {
  const [first, last] = ends.map((k) => poses[k]), [near, far] = centres;
  const arm = minus(apply(poses[links[links.length - 1]], far), near);
  const wanted = minus(apply(inverse(first), apply(last, far)), near);
  const q = shortestTurn(arm, wanted), ball = { t: minus(near, turned(q, near)), q };
  for (const k of links) poses[k] = joined(first, joined(ball, poses[k]));
}

/** Coordinates of joints by name, {value, kind, limits}, from the poses of the links on both sides. */
export function readJoints(readings, { poses }) {
  const found = {};
  for (const joint of readings) {
    const [before, after] = joint.links.map((k) => poses[k]);
    const values = readingsOf(joint, joined(inverse(before), after));
    joint.coordinates.forEach((c, k) => (found[c.name] = { ...c, value: c.kind === "angle" ? principal(values[k], c.limits) : values[k] }));
  }
  return found;
}

function readingsOf({ type, axis, axis2, point, zero, pitch }, between) {
  const { q } = between;
  if (type === "S") return [q[0] < 0 ? q.map((v) => -v) : q];
  const slide = dot(axis, minus(apply(between, point), point)), angle = halfTurn(dot(axis, q.slice(1)), q[0]);
  switch (type) {
    case "R": return [zero + angle];
    case "P": return [zero + slide];
    case "H": return [zero + (2 * Math.PI * slide) / pitch];
    case "C": return [angle, slide];
    default: {
      const back = [q[0], -q[1], -q[2], -q[3]];
      return [turnAbout(axis, axis2, turned(q, axis2)), -turnAbout(axis2, axis, turned(back, axis))];
    }
  }
}

function principal(value, limits) {
  let angle = value - 2 * Math.PI * Math.round(value / (2 * Math.PI));
  if (angle <= -Math.PI + 1e-15) angle += 2 * Math.PI;
  if (!limits || (angle >= limits[0] && angle <= limits[1])) return angle;
  const moved = angle + 2 * Math.PI * Math.ceil((limits[0] - angle) / (2 * Math.PI) - 1e-12);
  return moved <= limits[1] + 1e-12 ? moved : angle;
}

function halfTurn(sine, cosine) {
  const sign = cosine < 0 ? -1 : 1;
  return 2 * Math.atan2(sign * sine, sign * cosine);
}

function turnAbout(axis, start, end) {
  const along = dot(axis, start), flat = start.map((v, k) => v - along * axis[k]);
  return Math.atan2(dot(axis, cross(flat, end)), dot(flat, end));
}

function shortestTurn(a, b) {
  const p = scaled(a, 1 / length(a)), r = scaled(b, 1 / length(b)), w = 1 + dot(p, r);
  if (w > 1e-12) return unit([w, ...cross(p, r)]);
  const least = p.map(Math.abs).indexOf(Math.min(...p.map(Math.abs)));
  return unit([0, ...cross(p, [0, 1, 2].map((k) => Number(k === least)))]);
}

const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const minus = (a, b) => a.map((v, k) => v - b[k]);
const scaled = (a, f) => a.map((v) => v * f);
const length = (a) => Math.hypot(...a);
const unit = (q) => scaled(q, 1 / length(q));

function product([aw, ax, ay, az], [bw, bx, by, bz]) {
  return [
    aw * bw - ax * bx - ay * by - az * bz,
    aw * bx + ax * bw + ay * bz - az * by,
    aw * by - ax * bz + ay * bw + az * bx,
    aw * bz + ax * by - ay * bx + az * bw,
  ];
}

function turned([w, ...v], p) {
  const t = scaled(cross(v, p), 2), u = cross(v, t);
  return p.map((c, k) => c + w * t[k] + u[k]);
}

const apply = ({ t, q }, p) => turned(q, p).map((v, k) => v + t[k]);
const joined = (a, b) => ({ t: apply(a, b.t), q: product(a.q, b.q) });

function inverse({ t, q }) {
  const back = [q[0], -q[1], -q[2], -q[3]];
  return { t: scaled(turned(back, t), -1), q: back };
}

function rows({ t, q }) {
  const columns = [[1, 0, 0], [0, 1, 0], [0, 0, 1]].map((way) => turned(q, way));
  return [0, 1, 2].flatMap((k) => [columns[0][k], columns[1][k], columns[2][k], t[k]]);
}
