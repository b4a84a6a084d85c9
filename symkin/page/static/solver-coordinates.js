// Coordinates: their standard writing, how far they are beyond limits, and how far two configurations are apart.

/** A coordinate of x in its standard writing: angles in (-pi, pi] and moved into their limits, quaternions with w >= 0. */
export function plainValue(c, x) {
  if (c.kind === "quaternion") return positive(x.subarray(c.place, c.place + 4));
  const value = x[c.place];
  if (c.kind !== "angle") return c.least !== null && value < c.least ? 2 * c.least - value : value;
  return intoLimits(withoutTurns(value), c.limits);
}

function withoutTurns(angle) {
  const turned = angle - 2 * Math.PI * Math.round(angle / (2 * Math.PI));
  return turned <= -Math.PI + 1e-15 ? turned + 2 * Math.PI : turned;
}

function intoLimits(angle, limits) {
  if (!limits || (angle >= limits[0] && angle <= limits[1])) return angle;
  const moved = angle + 2 * Math.PI * Math.ceil((limits[0] - angle) / (2 * Math.PI) - 1e-12);
  return moved <= limits[1] + 1e-12 ? moved : angle;
}

/** How far a coordinate's value is beyond its limits, below zero under the lower one; whole turns of an angle that is `read` do not count. */
export function beyond({ kind, read, low, high }, value) {
  if (read && kind === "angle") value -= 2 * Math.PI * Math.round((value - 0.5 * (low + high)) / (2 * Math.PI));
  return value > high ? value - high : Math.min(0, value - low);
}

export function positive(q) {
  const length = Math.hypot(...q), lead = [...q].find((v) => Math.abs(v) > 1e-12 * length) ?? 1;
  return [...q].map((v) => (v * Math.sign(lead)) / length + 0);
}

/** Coordinates of x in their standard writing, in place. */
export function standard(coordinates, x) {
  for (const c of coordinates) x.set([plainValue(c, x)].flat(), c.place);
  return x;
}

/** Distance of two solutions, real (pairs = 1) or complex (2): the same up to turns, signs of quaternions and of rods' lengths. */
export function apart({ columns }, coordinates, a, b, pairs) {
  const gap = (k, shift = 0, sign = 1) =>
    pairs === 1 ? Math.abs(a[k] - sign * b[k] - shift) : Math.hypot(a[2 * k] - sign * b[2 * k] - shift, a[2 * k + 1] - sign * b[2 * k + 1]);
  let most = 0;
  for (const { kind, place: k, least } of coordinates) {
    const here = a[pairs * k];
    let d;
    if (kind === "quaternion") d = Math.min(...[1, -1].map((sign) => Math.max(...[0, 1, 2, 3].map((i) => gap(k + i, 0, sign)))));
    else if (kind === "angle") d = gap(k, 2 * Math.PI * Math.round((here - b[pairs * k]) / (2 * Math.PI)));
    else d = least === null ? gap(k) : Math.min(gap(k), gap(k, 2 * least, -1));
    most = Math.max(most, d / columns[k] / (1 + Math.abs(here) / columns[k]));
  }
  return most;
}
