// Sliders and number fields of the given coordinates.

const DIGITS = 6;
const THOUSANDS = /^[+-]?[1-9]\d{0,2},\d{3}$/; // 1,000 is a thousand to some and one to others
const NUMBER = /^[+-]?(\d+\.?\d*|\.\d+)(e[+-]?\d+)?$/i;

export class Inputs {
  /** Rows of `parent`, one a name in order; `ranges` {name: [low, high]} in the units of `units`; `onChange(name, value)` at every movement. */
  constructor(parent, { names, units, values, ranges }, onChange) {
    this.rows = new Map(names.map((name, k) => [name, new Row(parent.children[k], units[name], ranges[name], (value) => onChange(name, value))]));
    this.show(values);
  }

  show(values) {
    for (const [name, row] of this.rows) row.show(values[name]);
  }

  /** The ends of a slider as it is now. */
  ends(name) {
    const { slider } = this.rows.get(name);
    return [Number(slider.min), Number(slider.max)];
  }

  /** Mark on the slider how far a coordinate may move on, [low, high]; nothing of null. */
  mark(name, left) {
    this.rows.get(name)?.mark(left);
  }
}

class Row {
  constructor(element, unit, range, onChange) {
    Object.assign(this, { unit, range });
    [this.number, this.slider, this.left] = ["[type=text]", "[type=range]", ".left"].map((name) => element.querySelector(name));
    this.ends = element.querySelectorAll(".ends span");
    this.slider.addEventListener("input", () => onChange(this.slider.valueAsNumber));
    this.slider.addEventListener("keydown", (event) => this._step(event, onChange));
    this.number.addEventListener("change", () => this._typed(onChange));
    this.number.addEventListener("blur", () => this.number.getAttribute("aria-invalid") !== "true" && this.show(this.value));
    this.number.addEventListener("keydown", (event) => event.key === "Escape" && this._restore());
  }

  /** Arrow keys move by a two-hundredth of the range, with Shift by a tenth of that. */
  _step(event, onChange) {
    const way = { ArrowRight: 1, ArrowUp: 1, ArrowLeft: -1, ArrowDown: -1, PageUp: 10, PageDown: -10 }[event.key];
    if (!way) return;
    event.preventDefault();
    const step = ((this.range[1] - this.range[0]) / 200) * (event.shiftKey ? 0.1 : 1);
    // keys come faster than movements are shown: each goes on from what the last one asked for
    this.asked = Math.min(this.range[1], Math.max(this.range[0], (this.asked ?? this.value) + way * step));
    onChange(this.asked);
  }

  _typed(onChange) {
    const text = this.number.value.trim().replace(",", ".").replace("−", "-"), value = Number(text);
    const thousands = THOUSANDS.test(this.number.value.trim()), good = NUMBER.test(text) && Number.isFinite(value) && !thousands;
    this.number.setAttribute("aria-invalid", String(!good));
    if (good) return onChange(value);
    const told = thousands ? "may be two numbers; write it without the comma, or with a point" : `is not a number; write one such as 12.5, in ${this.unit}`;
    this.number.dispatchEvent(new CustomEvent("refused", { bubbles: true, detail: `${JSON.stringify(this.number.value)} ${told}.` }));
  }

  /** Take back what was typed, and what was said of it. */
  _restore() {
    this.show(this.value);
    this.number.dispatchEvent(new CustomEvent("refused", { bubbles: true, detail: "" }));
    this.number.blur();
  }

  show(value) {
    this.value = value;
    this.asked = null;
    this.number.removeAttribute("aria-invalid");
    this.number.value = shown(value);
    // a value beyond the slider widens it
    const [low, high] = [Math.min(this.range[0], value), Math.max(this.range[1], value)];
    this.slider.min = low;
    this.slider.max = high;
    [low, high].forEach((end, k) => (this.ends[k].textContent = shown(end, 4)));
    this.slider.value = value;
    this.slider.setAttribute("aria-valuetext", `${shown(value)} ${this.unit}`);
  }

  mark(left) {
    const share = (value) => 100 * Math.min(1, Math.max(0, (value - this.slider.min) / (this.slider.max - this.slider.min)));
    const [low, high] = left ?? [this.slider.min, this.slider.max];
    this.left.style.left = `${share(low)}%`;
    this.left.style.right = `${100 - share(high)}%`;
    this.left.classList.toggle("ends-low", Boolean(left) && low > this.slider.min);
    this.left.classList.toggle("ends-high", Boolean(left) && high < this.slider.max);
  }
}

export function shown(value, digits = DIGITS) {
  if (value === undefined || value === null || Number.isNaN(value)) return "";
  const text = Math.abs(value) < 1e-9 ? "0" : Number(value).toPrecision(digits);
  return text.includes("e") ? text : text.includes(".") ? text.replace(/\.?0+$/, "") : text;
}

export function element(tag, properties = {}) {
  return Object.assign(document.createElement(tag), properties);
}
