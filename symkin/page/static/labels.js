// Names and measures beside what they name, and the tip under the pointer.
import { element, shown } from "symkin/inputs";

export class Labels {
  constructor(layer, drawing, solver) {
    this.layer = layer;
    this.drawing = drawing;
    this.solver = solver;
    this.names = this.measures = false;
    this.entries = drawing.scene.items.filter((item) => item.at).map((item) => {
      const mark = element("span", { className: `label ${item.kind} ${item.role ?? ""}`, hidden: true });
      layer.append(mark);
      return { item, at: item.at, element: mark };
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
    return [this.names && item.label, this.measures && measureOf(item, this)].filter(Boolean).join(" ");
  }

  /** What the tip says of an item. */
  told(item) {
    return [item.told, measureOf(item, this)].filter(Boolean).join(", ");
  }
}

function measureOf(item, { solver, drawing }) {
  if (item.kind === "rod") {
    const [a, b] = item.at.map((end) => drawing.items.at(end));
    return `${shown(a.distanceTo(b), 5)} ${drawing.scene.lengthUnit}`;
  }
  if (item.kind !== "joint") return "";
  const joints = solver.solution()?.joints ?? {};
  const known = item.coordinates.filter((name) => typeof joints[name] === "number");
  return known.map((name) => `${shown(joints[name], 5)} ${solver.unitOf(name)}`).join(", ");
}
