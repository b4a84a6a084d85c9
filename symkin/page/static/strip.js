// The strip of small views, one a mode; a click takes it.
import { element } from "symkin/inputs";

const MOST = 64; // small views at most
const SEARCH = 12; // milliseconds of a frame for a search
const QUICK = 5; // milliseconds within which the modes are found at every movement; others are where nothing moves
const DRAWING = 8; // milliseconds of a frame for small views where nothing moves; at least one of them is drawn

export class Strip {
  constructor(list, text, { solver, drawing, onChoose }) {
    Object.assign(this, { list, text, solver, drawing, onChoose });
    this.buttons = [];
    this.modes = [];
    [this.took, this.spent] = [Infinity, 0]; // milliseconds of the last search, and so far of the one that goes on
    this.old = false; // whether the modes are those of other values
    [this.last, this.stale] = [-1, 0]; // the small view drawn last, and how many after it are to be drawn anew
    list.addEventListener("keydown", (event) => this._key(event));
  }

  /** The values changed: find the modes anew. */
  changed() {
    [this.old, this.spent] = [true, 0];
  }

  refresh() {
    const before = performance.now();
    this.old = !this.solver.findModes(SEARCH);
    this.spent += performance.now() - before;
    if (this.old) return;
    this.modes = this.solver.modes();
    [this.took, this.spent] = [this.spent, 0];
    this.poses = this.modes.slice(0, MOST).map((mode) => Float64Array.from(this.solver.linkPoses(mode)));
    this._words();
    this._buttons();
    this.draw();
  }

  /** Draw the small views anew as the large one is seen, in this frame and the next ones. */
  draw() {
    this.stale = this.buttons.length;
    this.box = null;
  }

  /** One frame: find modes, and draw some of the small views. */
  step(still) {
    if (this.old && (still || this.took < QUICK)) this.refresh();
    if (this.old) this.text.textContent = still ? "Finding all modes …" : "Finding all modes once nothing moves …";
    if (!this.stale) return;
    const count = this.buttons.length, turns = Array.from({ length: this.stale }, (_, k) => (this.last + k + 1) % count);
    const jobs = turns.map((k) => [this.buttons[k].firstChild, this.poses[k]]);
    this.box ??= this.drawing.boxOf(this.poses);
    const drawn = this.drawing.drawSmall(jobs, this.box, performance.now() + (still ? DRAWING : 0));
    [this.last, this.stale] = [turns[drawn - 1], this.stale - drawn];
  }

  _words() {
    const count = this.modes.length, sentence = this.solver.modesSentence ?? "";
    const counted = count === 1 ? "1 mode" : `${count} modes`;
    const most = count > MOST ? `; the first ${MOST} are shown, different poses and motors before others` : "";
    this.text.textContent = `${counted} ${this.solver.modesComplete ? "" : "found "}at these values${most}. ${sentence}`.trim();
  }

  _buttons() {
    while (this.buttons.length < this.poses.length) this._add(this.buttons.length);
    while (this.buttons.length > this.poses.length) this.buttons.pop().remove();
    this.buttons.forEach((button, k) => {
      const chosen = k === this.solver.modeIndex, mode = this.modes[k];
      if (chosen && button.getAttribute("aria-selected") !== "true") this._bring(button);
      button.setAttribute("aria-selected", String(chosen));
      button.tabIndex = chosen || (this.solver.modeIndex < 0 && k === 0) ? 0 : -1;
      const outside = mode.within_limits === false;
      button.classList.toggle("outside", outside);
      button.lastChild.textContent = outside ? `${k + 1} · outside limits` : `${k + 1}`;
      button.setAttribute("aria-label", `mode ${k + 1}${chosen ? ", shown" : ""}${outside ? ", outside the limits" : ""}`);
    });
  }

  /** Into sight, by moving the strip alone. */
  _bring(button) {
    const [left, right] = [button.offsetLeft - this.list.offsetLeft, button.offsetLeft - this.list.offsetLeft + button.offsetWidth];
    if (left < this.list.scrollLeft || right > this.list.scrollLeft + this.list.clientWidth) this.list.scrollLeft = left;
  }

  _add(k) {
    const button = element("button", { type: "button" });
    button.setAttribute("role", "option");
    button.append(element("canvas"), element("span"));
    button.addEventListener("click", () => this.onChoose(k));
    this.list.append(button);
    this.buttons.push(button);
  }

  _key(event) {
    const step = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
    if (!step) return;
    event.preventDefault();
    const next = (this.buttons.indexOf(document.activeElement) + step + this.buttons.length) % this.buttons.length;
    this.buttons[next]?.focus();
  }
}
