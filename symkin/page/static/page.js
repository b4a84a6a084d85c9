// Joins the solver, the drawing and the controls; offers `window.symkin`.
import { createSolver, percent } from "solver";
import * as generated from "generated";
import { Drawing, roundLength } from "symkin/drawing";
import { PlatformDrag } from "symkin/drag";
import { Inputs, shown } from "symkin/inputs";
import { Labels } from "symkin/labels";
import { PlaneMap } from "symkin/plane";
import { Player } from "symkin/player";
import { Strip } from "symkin/strip";
import { Trace } from "symkin/trace";

const $ = (id) => document.getElementById(id);
const { model, scene, options } = JSON.parse($("data").textContent);
const solver = createSolver(model, generated);
solver.unitOf = (name) => solver.units[name] ?? "";
const drawing = new Drawing($("view"), scene, solver.links.length);
const inputs = new Inputs($("inputs"), { names: solver.names, units: solver.units, values: solver.values, ranges: options.ranges }, wish);
const labels = new Labels($("labels"), drawing, solver);
const strip = new Strip($("strip"), $("modes-text"), { solver, drawing, onChoose: choose });
const drag = new PlatformDrag(drawing, solver, { itemAt, onMove: moved });
const trace = new Trace(drawing, tracedPoints());
const MAP_ROUNDS = 100; // steps of a drag to a place on a map
const wishes = new Map(); // values that sliders ask for, taken once a frame
const PAUSE = 10; // frames without a movement after which nothing moves
let player = null, plane = null, still = 0, unmarked = [];

window.symkinPage = drawing;
window.symkin = {
  names: [...solver.names],
  units: { ...solver.units },
  set: (values) => moved(solver.set(values)),
  solution: () => solver.solution(),
  modes: () => solver.modes(),
  choose,
};

/** The named points of moving links, and the origin of the platform's frame. */
function tracedPoints() {
  const frames = scene.items.filter((item) => item.kind === "frame" && item.name !== "base");
  const points = scene.items.filter((item) => item.kind === "point" && scene.items.some((body) => body.kind === "body" && body.link === item.link && body.role !== "base"));
  return [...points, ...frames.map((item) => ({ link: item.link, point: item.position }))];
}

// --- movements -------------------------------------------------------------------------------------------------------

function wish(name, value) {
  player?.play(false);
  wishes.set(name, value);
}

function choose(index) {
  const taken = solver.choose(index);
  if (taken) {
    trace.clear();
    stand(null);
    strip.refresh();
  }
  return taken;
}

/** Show where the mechanism is after a movement; returns what the movement came to. */
function moved(result) {
  drawing.place(solver.linkPoses());
  trace.add();
  plane?.draw();
  inputs.show(solver.values);
  tell(result.stop);
  readout();
  strip.changed();
  for (const name of solver.names) inputs.mark(name, null);
  [still, unmarked] = [0, [...solver.names]];
  return result;
}

/** Show where the mechanism stands without a movement. */
function stand(stop) {
  moved({ reached: true, share: 1, stop });
}

/** Show where the platform was dragged, and say so where it could not come to the place. */
function dragged(result, position) {
  moved(result);
  const off = Math.hypot(...solver.solution().position.map((v, k) => v - position[k]));
  if (!result.stop && off > 1e-3 * model.size)
    $("status").textContent = `The platform cannot come there in this mode: it stands as near as it can, ${shown(off, 3)} ${scene.lengthUnit} away.`;
  return result;
}

/** The sentence of a stop, and the motion that shows it. */
function tell(stop) {
  const sentence = stop?.sentence ?? "";
  if ($("status").textContent !== sentence) $("status").textContent = sentence;
  drawing.clearExtras("twist");
  const at = solver.solution()?.position;
  if (stop?.motion && at) drawing.showTwist(stop.motion, at);
}

/** Mark on the next slider how far it may move on. */
function mark() {
  const name = unmarked.shift();
  inputs.mark(name, solver.rangeLeft(name, inputs.ends(name)));
}

// --- numbers ---------------------------------------------------------------------------------------------------------

function readout() {
  const solution = solver.solution();
  const unit = scene.lengthUnit, rows = [];
  if (solution?.position) {
    rows.push(...["x", "y", "z"].map((axis, k) => [axis, shown(solution.position[k]), unit]));
    rows.push(...["qw", "qx", "qy", "qz"].map((part, k) => [part, shown(solution.quaternion[k], 5), ""]));
  }
  $("readout").caption.textContent = solution?.position ? `${options.frameName} pose` : "";
  fill($("readout").tBodies[0], rows);
  const others = Object.entries(solution?.joints ?? {}).filter(([name, value]) => typeof value === "number" && !solver.names.includes(name));
  const within = solution?.within_limits;
  $("limits").textContent = within === null ? "" : within ? "All joints are within their limits." : `Outside its limits: ${firstOf(outside(solution.joints))}.`;
  $("limits").classList.toggle("outside", within === false);
  $("passive").hidden = !others.length;
  $("passive").firstElementChild.textContent = `${others.length} other joint coordinates`;
  if ($("passive").open) fill($("passive").querySelector("tbody"), others.map(([name, value]) => [name, shown(value), solver.unitOf(name)]));
  const distance = solver.distanceToSingularity();
  $("gauge").hidden = distance === null;
  if (!$("gauge").hidden) {
    // decades from 1e-4 to 1
    $("distance").value = Math.min(1, Math.max(0, 1 + Math.log10(Math.max(distance, 1e-12)) / 4));
    $("distance-text").textContent = Number(distance).toPrecision(2);
  }
}

function outside(joints) {
  const beyond = ([name, value]) => solver.limits[name] && (value < solver.limits[name][0] || value > (solver.limits[name][1] ?? Infinity));
  return Object.entries(joints).filter(beyond).map(([name]) => name);
}

function fill(body, rows) {
  while (body.rows.length > rows.length) body.deleteRow(-1);
  rows.forEach((cells, k) => {
    const row = body.rows[k] ?? body.insertRow();
    cells.forEach((text, c) => {
      const cell = row.cells[c] ?? row.insertCell();
      if (cell.textContent !== text) cell.textContent = text;
    });
  });
}

// --- tools -----------------------------------------------------------------------------------------------------------

function toggle(id, action) {
  $(id).addEventListener("click", () => {
    const pressed = $(id).getAttribute("aria-pressed") !== "true";
    $(id).setAttribute("aria-pressed", String(pressed));
    action(pressed);
  });
}

function dress(dark) {
  document.documentElement.dataset.theme = dark ? "dark" : "light";
  $("theme").setAttribute("aria-pressed", String(dark));
  drawing.setDark(dark);
  strip.draw();
}

function itemAt(event) {
  const box = $("view").getBoundingClientRect();
  return drawing.itemAt(event.clientX - box.left, event.clientY - box.top);
}

function hover(event) {
  const item = event.buttons ? null : itemAt(event), tip = $("tip");
  tip.hidden = !item;
  $("view").classList.toggle("platform", item?.role === "platform");
  if (!item) return;
  const box = $("stage").getBoundingClientRect();
  tip.textContent = labels.told(item);
  const left = Math.min(event.clientX - box.left + 14, box.width - tip.offsetWidth - 8);
  tip.style.transform = `translate(${Math.max(8, left)}px, ${Math.max(8, event.clientY - box.top - 34)}px)`;
}

function scaleBar() {
  const length = roundLength(110 * drawing.lengthOfPixel);
  $("scale").firstElementChild.style.width = `${length / drawing.lengthOfPixel}px`;
  $("scale").lastElementChild.textContent = `${shown(length, 4)} ${scene.lengthUnit}`;
}

function frame(now) {
  still += 1;
  if (wishes.size) {
    const values = Object.fromEntries(wishes);
    wishes.clear();
    moved(solver.set(values));
  }
  drag.step();
  plane?.step();
  player?.step(now);
  strip.step(still > PAUSE);
  if (still > PAUSE && unmarked.length) mark();
  drawing.render();
  requestAnimationFrame(frame);
}

/** The first few of some names, and how many more there are. */
function firstOf(names, count = 5) {
  return names.slice(0, count).join(", ") + (names.length > count ? ` and ${names.length - count} more` : "");
}

// --- beginning -------------------------------------------------------------------------------------------------------

toggle("names", (on) => labels.set(on, labels.measures));
toggle("measures", (on) => labels.set(labels.names, on));
toggle("theme", dress);
toggle("trace", (on) => trace.set(on));
$("trace").hidden = !tracedPoints().length;
toggle("meshes", (on) => drawing.setMeshes(on));
$("meshes").hidden = !drawing.items.meshes.length;
toggle("heed", (on) => {
  solver.heedsLimits = on;
  stand(solver.stopHere());
});
$("heed").hidden = !solver.limited.length;
$("fit").addEventListener("click", () => drawing.fit());
$("reset").addEventListener("click", () => {
  player?.rewind();
  solver.takeStart();
  stand(solver.stopHere());
});
$("passive").addEventListener("toggle", readout);
$("inputs").addEventListener("refused", (event) => ($("status").textContent = event.detail));
$("view").addEventListener("pointermove", hover);
$("view").addEventListener("pointerleave", () => ($("tip").hidden = true));
$("view").addEventListener("contextmenu", (event) => event.preventDefault());
document.addEventListener("keydown", (event) => {
  const keys = { n: "names", m: "measures", f: "fit", d: "theme", t: "trace", l: "heed" };
  const typing = event.target.matches?.("input[type=text], select") || event.ctrlKey || event.metaKey || event.altKey;
  if (!typing && keys[event.key.toLowerCase()]) $(keys[event.key.toLowerCase()]).click();
});
drawing.listeners.push(scaleBar);
let viewed = "";
drawing.listeners.push(() => {
  const now = drawing.axes.flat().map((v) => v.toFixed(3)).join();
  if (now !== viewed) strip.draw();
  viewed = now;
});
if (options.plane) {
  const { names } = options.plane, axes = names.map((name) => "xyz".indexOf(name));
  const given = names.every((name) => solver.names.includes(name));
  const others = given ? solver.names.filter((name) => !names.includes(name)) : [], first = { ...solver.values };
  const off = () => others.filter((name) => Math.abs(solver.values[name] - first[name]) > 1e-6 * Math.max(1, Math.abs(first[name])));
  plane = new PlaneMap($("plane"), options.plane, {
    off,
    now: () => names.map((name, k) => (given ? solver.values[name] : solver.solution().position[axes[k]])),
    go: (...place) => {
      if (given) return moved(solver.set(Object.fromEntries(names.map((name, k) => [name, place[k]]))));
      const pose = options.plane.pose ?? solver.solution().position.concat(solver.solution().quaternion), position = pose.slice(0, 3);
      axes.forEach((axis, k) => (position[axis] = place[k]));
      return dragged(solver.dragTo(position, pose.slice(3), MAP_ROUNDS), position);
    },
  });
}
if (options.path) {
  player = new Player($("player"), options.path, {
    go: (values) => moved(solver.set(values)),
    onStop: (stop, share) => tell({ ...stop, sentence: `Stopped at ${percent(share)} of the path${stop.cause}` }),
  });
  $("player").addEventListener("pointerdown", () => wishes.clear());
}
$("reset").parentElement.hidden = !solver.names.length;
$("hints").textContent = options.hint;
// names of options are not broken
const option = (name) => Object.assign(document.createElement("code"), { textContent: name });
$("notes").append(...scene.notes.join(" ").split(/(--\w+)/).map((part, k) => (k % 2 ? option(part) : part)));
dress(options.dark ?? window.matchMedia?.("(prefers-color-scheme: dark)").matches ?? false);
stand(solver.stopHere());
drawing.fit();
new ResizeObserver(() => drawing.resize()).observe($("stage"));
requestAnimationFrame(frame);
document.documentElement.dataset.ready = "yes";
