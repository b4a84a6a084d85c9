// Names and measures beside what they name, and the tip under the pointer.
import { element, shown } from "symkin/inputs";

const TYPES = { R: "revolute", P: "prismatic", C: "cylindrical", H: "helical", U: "universal", S: "spherical", weld: "weld" };

export class Labels {
  constructor(layer, drawing, solver) {
    this.layer = layer;
    this.drawing = drawing;
    this.solver = solver;
    this.names = this.measures = false;
    this.entries = drawing.items.labels.map(({ item, at }) => {
      const mark = element("span", { className: `label ${item.kind} ${item.role ?? ""}`, hidden: true });
      layer.append(mark);
      return { item, at, element: mark };
    });
    drawing.listeners.push(() => this.update());
  }

  set(names, measures) {
    this.names = names;
    this.measures = measures;
    this.update();
  }

  update() {
    const taken = [], right = this.layer.clientWidth;
    for (const { item, at, element } of this.entries) {
      const text = this._text(item);
      element.hidden = !text;
      if (!text) continue;
      if (element.textContent !== text) element.textContent = text;
      const ends = at.map((end) => this.drawing.items.at(end));
      const middle = ends[0].clone().add(ends[ends.length - 1]).multiplyScalar(0.5);
      const [x, y] = this.drawing.onScreen(middle);
      // to the left where the right edge would cut it
      const width = 6.4 * text.length + 8, left = x + 8 + width > right && x - 8 - width >= 0 ? x - 8 - width : x + 8;
      const box = [left, y - 20, left + width, y - 3];
      // a label that would cover another one steps aside, or waits
      const free = [0, 20, -18, 38].find((shift) => !taken.some((b) => box[0] < b[2] && b[0] < box[2] && box[1] + shift < b[3] && b[1] < box[3] + shift));
      element.hidden = free === undefined;
      if (free === undefined) continue;
      taken.push([box[0], box[1] + free, box[2], box[3] + free]);
      element.style.transform = `translate(${Math.round(box[0])}px, ${Math.round(box[1] + free)}px)`;
    }
  }

  _text(item) {
    const values = this.measures ? measureOf(item, this) : "";
    // links within a limb have no names of their own
    if (this.names && item.role !== "base" && !(item.kind === "body" && /\.\d+$/.test(item.name))) return values ? `${item.name} ${values}` : item.name;
    return values;
  }

  /** What the tip says of an item. */
  told(item) {
    if (item.kind === "body") return item.role === "link" ? `link ${item.name}` : item.role === "base" ? "base, the fixed link" : `${item.name}, the link of the platform frame`;
    if (item.kind === "point") return `point ${item.name}`;
    if (item.kind === "mesh") return `link ${item.name}`;
    const values = measureOf(item, this), drives = item.actuated ? "actuated " : "";
    const what = item.kind === "rod" ? `${drives}rod` : `${drives}${TYPES[item.type]} joint`;
    return `${item.name}: ${what}${values ? `, ${values}` : ""}`;
  }
}

function measureOf(item, { solver, drawing }) {
  if (item.kind === "rod") {
    const [a, b] = [item.from, item.to].map((end) => drawing.items.at(end));
    return `${shown(a.distanceTo(b), 5)} ${drawing.scene.lengthUnit}`;
  }
  if (item.kind !== "joint") return "";
  const joints = solver.solution()?.joints ?? {};
  const known = item.coordinates.filter((name) => typeof joints[name] === "number");
  return known.map((name) => `${shown(joints[name], 5)} ${solver.unitOf(name)}`).join(", ");
}
