// Small views: a configuration as lines in a 2-D canvas, seen as the large view is.

/** Draw poses (12 numbers a link) into a canvas; `axes` are the directions right, up and towards the eye, `colour` a palette. */
export function drawSketch(canvas, scene, poses, axes, frame, colour) {
  const ratio = Math.min(window.devicePixelRatio || 1, 2);
  const width = canvas.clientWidth || 120, height = canvas.clientHeight || 90;
  if (canvas.width !== Math.round(width * ratio)) {
    canvas.width = Math.round(width * ratio);
    canvas.height = Math.round(height * ratio);
  }
  const pen = canvas.getContext("2d");
  pen.setTransform(ratio, 0, 0, ratio, 0, 0);
  pen.clearRect(0, 0, width, height);
  pen.lineCap = pen.lineJoin = "round";
  const scale = 0.86 * Math.min(width / (2 * frame.half[0]), height / (2 * frame.half[1]));
  const seen = (point, link) => {
    const p = moved(poses, link, point);
    const flat = axes.map((way) => way[0] * p[0] + way[1] * p[1] + way[2] * p[2]);
    return [0.5 * width + scale * (flat[0] - frame.centre[0]), 0.5 * height - scale * (flat[1] - frame.centre[1]), flat[2]];
  };
  const strokes = scene.items.flatMap((item) => strokesOf(item, seen, colour));
  strokes.sort((a, b) => a.depth - b.depth).forEach((stroke) => stroke.draw(pen));
}

/** Half sides and centre of the picture that holds several configurations. */
export function frameOf(scene, manyPoses, axes) {
  const low = [Infinity, Infinity], high = [-Infinity, -Infinity];
  for (const poses of manyPoses) {
    for (const item of scene.items) {
      const places = item.kind === "body" ? item.points.map((p) => [item.link, p]) : [];
      for (const [link, point] of places) {
        const p = moved(poses, link, point);
        for (const k of [0, 1]) {
          const value = axes[k][0] * p[0] + axes[k][1] * p[1] + axes[k][2] * p[2];
          low[k] = Math.min(low[k], value);
          high[k] = Math.max(high[k], value);
        }
      }
    }
  }
  const least = 0.1 * scene.size;
  return {
    centre: [0, 1].map((k) => 0.5 * (low[k] + high[k])),
    half: [0, 1].map((k) => Math.max(0.5 * (high[k] - low[k]), least)),
  };
}

function moved(poses, link, point) {
  const p = poses.subarray ? poses.subarray(12 * link, 12 * link + 12) : poses.slice(12 * link, 12 * link + 12);
  return [0, 1, 2].map((k) => p[4 * k] * point[0] + p[4 * k + 1] * point[1] + p[4 * k + 2] * point[2] + p[4 * k + 3]);
}

function strokesOf(item, seen, colour) {
  switch (item.kind) {
    case "body": return bodyStrokes(item, seen, colour);
    case "rod": return [line(seen(item.from.point, item.from.link), seen(item.to.point, item.to.link), item.actuated ? colour("accent") : colour("link"), 1.8)];
    case "joint": return [dot(seen(item.point, item.links[1]), item.actuated ? colour("accent") : colour("white"), colour("link"))];
    default: return [];
  }
}

function bodyStrokes(item, seen, colour) {
  const places = item.points.map((point) => seen(point, item.link)), tint = colour(item.colour);
  const faces = item.faces.map((ring) => area(ring.map((k) => places[k]), tint));
  const width = item.role === "platform" ? 2.6 : item.role === "base" ? 1 : 2;
  return [...faces, ...item.edges.map(([a, b]) => line(places[a], places[b], tint, width))];
}

function line(a, b, tint, width) {
  return {
    depth: 0.5 * (a[2] + b[2]),
    draw: (pen) => {
      pen.strokeStyle = tint;
      pen.lineWidth = width;
      pen.beginPath();
      pen.moveTo(a[0], a[1]);
      pen.lineTo(b[0], b[1]);
      pen.stroke();
    },
  };
}

function area(corners, tint) {
  return {
    depth: corners.reduce((sum, c) => sum + c[2], 0) / corners.length - 1e-6,
    draw: (pen) => {
      pen.globalAlpha = 0.2;
      pen.fillStyle = tint;
      pen.beginPath();
      corners.forEach((c, k) => (k ? pen.lineTo(c[0], c[1]) : pen.moveTo(c[0], c[1])));
      pen.fill();
      pen.globalAlpha = 1;
    },
  };
}

function dot(place, fill, edge) {
  return {
    depth: place[2] + 1e-3,
    draw: (pen) => {
      pen.fillStyle = fill;
      pen.strokeStyle = edge;
      pen.lineWidth = 1;
      pen.beginPath();
      pen.arc(place[0], place[1], 2.2, 0, 2 * Math.PI);
      pen.fill();
      pen.stroke();
    },
  };
}
