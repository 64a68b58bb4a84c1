// Arms with joints to spare: how they move along a direction and in place, and all poses that hold the effector.
import { button, el } from "../dom";
import { OKABE } from "../palette";
import { SelfMotion } from "../protocol";
import { Store } from "../store";

const DIRECTIONS = ["along x", "along y", "along z", "about x", "about y", "about z"];
const WIDTH = 240, HEIGHT = 110;

function svg<K extends keyof SVGElementTagNameMap>(tag: K, props: Record<string, string | number>): SVGElementTagNameMap[K] {
  const node = document.createElementNS("http://www.w3.org/2000/svg", tag);
  for (const [key, value] of Object.entries(props)) node.setAttribute(key, String(value));
  return node;
}

export class ArmPanel {
  private self: SelfMotion | null = null;
  private effector = -1;
  private direction = 0;

  constructor(private store: Store, private changed: () => void) {}

  /** What is to be asked again when the pose has changed; "": nothing. */
  wanted(): string {
    return this.store.column >= 0 ? `columns ${this.effector} ${this.direction}` : "";
  }

  node(): HTMLElement | null {
    const { store } = this, { model } = store;
    if (model.substructures.length || model.coordinates.filter((c) => !c.held).length < 7) return null;
    return el("div", { class: "group" }, el("h2", { text: "Arm" }), el("div", { class: "chips" }, this.effectorChoice()),
      el("h3", { text: "Rates of the joints while the effector moves" }), this.columns(), el("h3", { text: "Poses that hold the effector" }), this.selfMotion());
  }

  private effectorChoice(): HTMLElement {
    const { store } = this, { model } = store, frames = model.frames.map((f, i) => ({ f, i })).filter(({ f }) => f.body > 0 && f.name !== "origin");
    if (this.effector < 0 || this.effector >= model.frames.length) this.effector = frames.length ? frames[frames.length - 1].i : model.frames.length - 1;
    const choice = el("select", { "aria-label": "Effector", onchange: () => {
      this.effector = Number(choice.value);
      this.self = null;
      this.forget();
    } }, ...frames.map(({ f, i }) => el("option", { value: i, selected: i === this.effector, text: `${model.bodies[f.body].name}/${f.name}` })));
    return choice;
  }

  private forget(): void {
    this.store.columns = null;
    this.store.column = -1;
    this.changed();
    this.store.tell("why");
  }

  /** The path-control column and the pose-control columns, one at a time as arrows at the joints. */
  private columns(): HTMLElement {
    const { store } = this, list = store.columns?.columns ?? [];
    const choice = el("select", { "aria-label": "Direction of the effector", onchange: () => {
      this.direction = Number(choice.value);
      if (store.column >= 0) void store.ask(this.wanted());
    } }, ...DIRECTIONS.map((text, i) => el("option", { value: i, selected: i === this.direction, text })));
    const show = async (): Promise<void> => {
      const answer = await store.ask(`columns ${this.effector} ${this.direction}`);
      if (answer.kind === "columns") store.column = 0;
      store.tell("why");
    };
    const pick = (k: number): void => {
      store.column = k;
      store.tell("why");
    };
    return el("div", { class: "chips" }, choice,
      store.column < 0 ? button("Show", "Show path-control and pose-control columns as arrows", () => void show()) : null,
      ...(store.column < 0 ? [] : list.map((_, k) => el("button", { type: "button", class: "chip", "aria-pressed": String(store.column === k), onclick: () => pick(k) }, k === 0 ? "path" : list.length > 2 ? `in place ${k}` : "in place"))),
      store.column >= 0 ? button("Hide", "Hide the columns", () => this.forget()) : null);
  }

  private selfMotion(): HTMLElement {
    const { store } = this;
    const find = async (): Promise<void> => {
      const answer = await store.ask(`selfmotion ${this.effector}`);
      this.self = answer.kind === "selfmotion" ? answer : null;
      this.changed();
    };
    return el("div", {}, el("div", { class: "chips" }, button("Find", "Find the poses that hold the effector where it is", () => void find())), this.self ? this.map(this.self) : null);
  }

  private go(self: SelfMotion, row: number): void {
    const { store } = this, q = Array.from(store.pose.q);
    self.coordinates.forEach((c, k) => (q[c] = self.q[row][k]));
    store.pull(`place ${q.join(" ")}`, () => false);
  }

  /** Where the pose stands among the rows; full turns don't count. */
  private at(self: SelfMotion): number {
    const { pose, model } = this.store;
    let best = 0, least = Infinity;
    self.q.forEach((row, r) => {
      let sum = 0;
      self.coordinates.forEach((c, k) => {
        const turn = model.coordinates[c].unit === "rad" ? 2 * Math.PI : model.coordinates[c].unit === "deg" ? 360 : 0;
        const d = row[k] - pose.q[c];
        sum += (turn ? d - turn * Math.round(d / turn) : d) ** 2;
      });
      if (sum < least) [best, least] = [r, sum];
    });
    return best;
  }

  /** The joints over the way along the self-motion: a click takes the pose there. A slider does the same by keys. */
  private map(self: SelfMotion): HTMLElement {
    const { store } = this, low = self.u[0], high = self.u[self.u.length - 1], wide = high - low || 1;
    const all = self.q.flat(), bottom = Math.min(...all), top = Math.max(...all), tall = top - bottom || 1;
    const x = (r: number): number => ((self.u[r] - low) / wide) * WIDTH, y = (v: number): number => HEIGHT - 3 - ((v - bottom) / tall) * (HEIGHT - 6);
    const picture = svg("svg", { viewBox: `0 0 ${WIDTH} ${HEIGHT}`, class: "map", role: "img", "aria-label": "Joints along the self-motion" });
    self.coordinates.forEach((c, k) => {
      const path = self.u.map((_, r) => `${r && self.arc[r] === self.arc[r - 1] ? "L" : "M"}${x(r).toFixed(1)} ${y(self.q[r][k]).toFixed(1)}`).join("");
      const line = svg("path", { d: path, fill: "none", stroke: OKABE[k % OKABE.length], "stroke-width": 1.6, "vector-effect": "non-scaling-stroke" });
      line.append(Object.assign(svg("title", {}), { textContent: store.model.coordinates[c].label }));
      picture.append(line);
    });
    const mark = svg("line", { y1: 0, y2: HEIGHT, stroke: "currentColor", "stroke-width": 1.2, "vector-effect": "non-scaling-stroke" });
    picture.append(mark);
    const slider = el("input", { type: "range", min: "0", max: String(self.u.length - 1), step: "1", "aria-label": "Along the self-motion", class: "wide" });
    const show = (row: number): void => {
      mark.setAttribute("x1", x(row).toFixed(1));
      mark.setAttribute("x2", x(row).toFixed(1));
      slider.value = String(row);
    };
    const take = (row: number): void => {
      show(row);
      this.go(self, row);
    };
    const point = (e: PointerEvent): void => {
      const box = picture.getBoundingClientRect(), u = low + ((e.clientX - box.left) / box.width) * wide;
      take(self.u.reduce((best, v, r) => (Math.abs(v - u) < Math.abs(self.u[best] - u) ? r : best), 0));
    };
    picture.addEventListener("pointerdown", (e) => {
      picture.setPointerCapture(e.pointerId);
      point(e);
    });
    picture.addEventListener("pointermove", (e) => e.buttons && point(e));
    picture.addEventListener("pointerup", () => void store.settle());
    slider.addEventListener("input", () => take(Number(slider.value)));
    slider.addEventListener("change", () => void store.settle());
    show(this.at(self));
    const arcs = new Set(self.arc).size;
    return el("div", {}, picture as unknown as HTMLElement, slider,
      el("p", { class: "hint", text: self.whole ? "A closed curve: every joint stays within its limits." : `${arcs} ${arcs === 1 ? "stretch" : "stretches"} within the limits.` }));
  }
}
