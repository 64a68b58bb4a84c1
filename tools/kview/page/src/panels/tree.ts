// Bodies and joints, each joint with its mobility number and a slider.
import { button, el, replace, shown, typed } from "../dom";
import { OKABE, scaleColour } from "../palette";
import { RecordedLink } from "../link";
import { Joint, Track } from "../protocol";
import { Store } from "../store";

const SYMBOLS: [RegExp, string, string][] = [
  [/^R/, "◎", "hinge"], [/^T/, "⇔", "slide"], [/rigid/, "■", "rigid"], [/spherical/, "●", "ball"], [/float/, "✥", "free"],
  [/cylindrical/, "⊜", "cylindrical"], [/universal/, "✛", "universal"], [/planar/, "▱", "planar"], [/screw/, "⌇", "screw"],
];

export function typeOf(joint: Joint): { symbol: string; word: string } {
  const found = SYMBOLS.find(([pattern]) => pattern.test(joint.type));
  return { symbol: found?.[1] ?? "·", word: found?.[2] ?? joint.type };
}

interface Row { node: HTMLElement; slider: HTMLInputElement | null; value: HTMLInputElement | null; bar: HTMLElement; number: HTMLElement; coordinate: number; joint: number; ticks: HTMLElement; seen: boolean }

/** The range of a coordinate's slider: its limits, or a turn or a few lengths about where it began. */
export function rangeOf(store: Store, coordinate: number, at: number): [number, number] {
  const c = store.model.coordinates[coordinate];
  const reach = c.unit === "rad" ? Math.PI : c.unit === "deg" ? 180 : 2 * store.model.length;
  return [c.low ?? (c.high !== null ? Math.min(at, c.high) - 2 * reach : at - reach), c.high ?? (c.low !== null ? Math.max(at, c.low) + 2 * reach : at + reach)];
}

export class Tree {
  readonly node = el("section", { class: "panel tree", "aria-label": "Bodies and joints" });
  private rows: Row[] = [];
  private list = el("div", { class: "rows" });
  private bodies = el("div", { class: "bodies" });
  private byNumber = false;
  private search = el("input", { type: "search", placeholder: "Search", "aria-label": "Search bodies and joints", oninput: () => this.filter() });
  private active = -1; // the slider that is held
  private shape = "";
  /** Of thousands of rows only those in sight follow each pose. */
  private sight = new IntersectionObserver((entries) => {
    for (const entry of entries) {
      const row = this.byNode.get(entry.target);
      if (row) row.seen = entry.isIntersecting;
    }
    this.follow();
  });
  private byNode = new Map<Element, Row>();

  constructor(private store: Store) {
    const sort = button("Sort by mobility", "Sort joints by mobility number", () => {
      this.byNumber = !this.byNumber;
      sort.setAttribute("aria-pressed", String(this.byNumber));
      this.sort();
    }, { "aria-pressed": "false", class: "small" });
    this.node.append(el("div", { class: "tools" }, this.search, sort), el("h2", { text: "Joints" }), this.list, el("h2", { text: "Bodies" }), this.bodies);
    store.on(["model"], () => this.build());
    store.on(["pose"], () => this.follow());
    store.on(["selection"], () => this.highlight());
  }

  private build(): void {
    const { model, pose } = this.store, shape = JSON.stringify([model.name, model.joints.map((j) => [j.label, j.type]), model.coordinates.map((c) => [c.held, c.low, c.high])]);
    if (shape === this.shape || !pose || pose.q.length !== model.coordinates.length) return;
    this.shape = shape;
    this.rows = [];
    model.joints.forEach((joint, j) => {
      if (!joint.count) this.rows.push(this.row(j, -1));
      for (let k = 0; k < joint.count; ++k) this.rows.push(this.row(j, joint.first + k));
    });
    this.sight.disconnect();
    this.byNode = new Map(this.rows.map((row) => [row.node, row]));
    if (this.rows.length > 60) for (const row of this.rows) this.sight.observe(row.node);
    this.sort();
    replace(this.bodies, ...model.bodies.map((body, b) =>
      el("button", { type: "button", class: "body", "data-body": b, onclick: () => this.store.select({ kind: "body", index: b }) },
        el("span", { class: "dot", style: `background:${this.store.bodyColour(b)}` }), b === 0 ? "fixed" : body.name,
        body.assembly > 0 ? el("small", { text: model.assemblies[body.assembly].name }) : null)));
    this.follow();
    this.highlight();
  }

  private row(j: number, coordinate: number): Row {
    const { model } = this.store, joint = model.joints[j], { symbol, word } = typeOf(joint), c = model.coordinates[coordinate];
    const name = c?.label ?? joint.label, recorded = this.store.link.recorded;
    const bar = el("i"), number = el("output", { class: "number", title: "mobility number" }), ticks = el("div", { class: "ticks", "aria-hidden": "true" });
    const pick = el("button", { type: "button", class: "name", title: `${word} ${joint.type}`, onclick: () => this.store.select({ kind: "joint", index: j }) },
      el("span", { class: "symbol", style: c && c.substructure >= 0 ? `color:${OKABE[c.substructure % OKABE.length]}` : "", text: symbol }), name);
    let slider: HTMLInputElement | null = null, value: HTMLInputElement | null = null, hold: HTMLElement | null = null;
    if (c) {
      slider = el("input", { type: "range", step: "any", "aria-label": `${name}, ${c.unit}`, disabled: c.held });
      value = el("input", { type: "text", inputmode: "decimal", class: "value", "aria-label": `Value of ${name} in ${c.unit}`, disabled: c.held });
      this.wire(slider, value, coordinate);
      hold = button(c.held ? "held" : "hold", `${c.held ? "Let go of" : "Hold"} ${name}`, () => this.hold(coordinate, !c.held), { class: "hold", "aria-pressed": String(c.held), disabled: recorded });
    }
    const meter = el("div", { class: "meter", role: "meter", "aria-label": `Mobility number of ${name}`, "aria-valuemin": "0", "aria-valuemax": "1" }, bar);
    const node = el("div", { class: "row", "data-joint": j, "data-coordinate": coordinate },
      el("div", { class: "line" }, pick, number, hold), meter,
      c ? el("div", { class: "line" }, el("div", { class: "track" }, slider, ticks), value, el("span", { class: "unit", text: c.unit })) : null);
    return { node, slider, value, bar, number, coordinate, joint: j, ticks, seen: true };
  }

  private wire(slider: HTMLInputElement, value: HTMLInputElement, coordinate: number): void {
    const { store } = this;
    slider.addEventListener("input", () => {
      this.active = coordinate;
      this.pull(coordinate, Number(slider.value), () => this.active === coordinate);
    });
    const done = (): void => {
      if (this.active !== coordinate) return;
      this.active = -1;
      void store.settle().then(() => this.follow()).then(() => this.askTrack(coordinate));
    };
    for (const end of ["change", "pointerup", "blur"]) slider.addEventListener(end, () => setTimeout(done, 30));
    slider.addEventListener("focus", () => store.select({ kind: "joint", index: store.model.coordinates[coordinate].joint }));
    slider.addEventListener("pointerenter", () => this.askTrack(coordinate));
    slider.addEventListener("focus", () => this.askTrack(coordinate));
    value.addEventListener("change", () => {
      const wanted = typed(value.value);
      if (!Number.isFinite(wanted)) {
        value.value = shown(store.pose.q[coordinate], 5);
        store.say(`"${store.model.coordinates[coordinate].label}" needs a number.`, true);
        return;
      }
      this.pull(coordinate, wanted, () => true);
      void store.settle();
    });
  }

  private pull(coordinate: number, target: number, going: () => boolean): void {
    const { store } = this, { link } = store;
    if (link instanceof RecordedLink) {
      const at = nearestRow(link, coordinate, target);
      link.pull(`row ${at}`, (answer) => store.take(answer));
    } else store.pull(`joint ${coordinate} ${target}`, going);
  }

  private hold(coordinate: number, held: boolean): void {
    void this.store.ask(`hold ${coordinate} ${held ? 1 : 0}`).then(() => this.store.ask("pose"));
  }

  /** Where the slider will meet a toggle or a limit. */
  private tracked = new Map<number, string>();
  private askTrack(coordinate: number): void {
    const { store } = this;
    if (store.link.recorded || this.active >= 0 || store.model.coordinates[coordinate].held) return;
    const stamp = Array.from(store.pose.q, (q) => q.toPrecision(5)).join();
    if (this.tracked.get(coordinate) === stamp) return;
    this.tracked.set(coordinate, stamp);
    void store.link.ask(`track ${coordinate}`).then((answer) => {
      if (answer.kind === "track") this.showTrack(answer);
    });
  }

  private showTrack(track: Track): void {
    const row = this.rows.find((r) => r.coordinate === track.coordinate);
    if (!row?.slider) return;
    const low = Number(row.slider.min), high = Number(row.slider.max);
    replace(row.ticks, ...track.events.filter((e) => e.s !== null && e.s! >= low && e.s! <= high).map((e) => {
      const kind = e.name === "limit" ? "limit" : e.own || e.name === "end" ? "end" : "toggle";
      const title = e.name === "limit" ? `${e.subject} reaches its limit` : kind === "end" ? "the end: a toggle of this joint" : `${e.name} of ${e.subject || "the mechanism"}`;
      return el("b", { class: kind, style: `left:${(100 * (e.s! - low)) / (high - low)}%`, title });
    }));
  }

  private follow(): void {
    const { pose, model } = this.store;
    if (!pose || pose.q.length !== model.coordinates.length || !this.rows.length) return;
    for (const row of this.rows) {
      if (!row.seen) continue;
      const number = row.coordinate >= 0 ? pose.m[row.coordinate] : 0;
      row.bar.style.width = `${100 * number}%`;
      row.bar.style.background = scaleColour(number);
      row.bar.parentElement!.setAttribute("aria-valuenow", number.toFixed(4));
      row.number.textContent = number.toFixed(4);
      if (!row.slider || !row.value) continue;
      const q = pose.q[row.coordinate];
      if (!row.slider.max || q < Number(row.slider.min) || q > Number(row.slider.max) || row.slider.dataset.set !== "1") {
        const [low, high] = rangeOf(this.store, row.coordinate, q);
        row.slider.min = String(low);
        row.slider.max = String(high);
        row.slider.dataset.set = "1";
      }
      if (this.active !== row.coordinate) row.slider.value = String(q);
      if (document.activeElement !== row.value) row.value.value = shown(q, 5);
      row.slider.setAttribute("aria-valuetext", `${shown(q, 5)} ${model.coordinates[row.coordinate].unit}`);
    }
    if (this.byNumber && this.active < 0) this.sort();
  }

  private sort(): void {
    const { pose } = this.store, order = [...this.rows];
    if (this.byNumber) order.sort((a, b) => (b.coordinate < 0 ? -1 : pose.m[b.coordinate]) - (a.coordinate < 0 ? -1 : pose.m[a.coordinate]));
    if (order.some((row, i) => this.list.children[i] !== row.node)) this.list.replaceChildren(...order.map((r) => r.node));
  }

  private filter(): void {
    const words = this.search.value.toLowerCase();
    for (const node of [...this.list.children, ...this.bodies.children] as HTMLElement[])
      node.hidden = words !== "" && !(node.textContent ?? "").toLowerCase().includes(words);
  }

  private highlight(): void {
    const { selection } = this.store;
    for (const row of this.rows) row.node.classList.toggle("on", selection?.kind === "joint" && selection.index === row.joint);
    for (const node of this.bodies.children) node.classList.toggle("on", selection?.kind === "body" && selection.index === Number((node as HTMLElement).dataset.body));
    const on = this.node.querySelector(".on");
    if (on && !this.node.contains(document.activeElement)) on.scrollIntoView({ block: "nearest" });
  }
}

/** The recorded row in which a coordinate is nearest to a value, near the present row where several are. */
function nearestRow(link: RecordedLink, coordinate: number, target: number): number {
  let best = link.at, least = Infinity;
  link.poses.forEach((bytes, row) => {
    const q = new DataView(bytes).getFloat64(48 + 8 * coordinate, true), far = Math.abs(q - target) + 1e-9 * Math.abs(row - link.at);
    if (far < least) [best, least] = [row, far];
  });
  return best;
}
