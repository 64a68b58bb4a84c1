// The map over two drivers beside the mechanism, or over the place of a point: found while the page goes on, and drawn
// with the present pose.
import { button, el, shown } from "../dom";
import { Answer, Table } from "../protocol";
import { Store } from "../store";
import { Axes, MapData, SIZE, columnOf, drawMap, overDrivers, overPoint } from "./map_picture";
import { rangeOf } from "./tree";

const STEPS = [24, 80]; // a first answer, then a fine one
const PAUSES = [10, 150]; // ms between two looks at a map that is being found: the first one, and the longest

export class MapPanel {
  private map: MapData | null = null;
  private axes: Axes | null = null;
  private drivers: [number, number] | null = null;
  private frame = -1; // of the point; -1: none
  private isOverPoint = true; // where the map has a point
  private column = "sigma.input";
  private part = 1; // number of the sheet or aspect
  private revision = -1; // of the model that the map is of
  private working = false;
  private stopped = false;
  private bar = el("progress", { max: 1, value: 0, "aria-label": "Share of the map that is found" });
  private picture = el("canvas", { width: SIZE, height: SIZE, class: "map square", tabindex: 0, role: "img" });
  private colours = el("p", { class: "hint" });

  constructor(private store: Store, private changed: () => void) {
    this.picture.addEventListener("pointerdown", (e) => {
      this.picture.setPointerCapture(e.pointerId);
      this.point(e);
    });
    this.picture.addEventListener("pointermove", (e) => e.buttons && this.point(e));
    this.picture.addEventListener("pointerup", () => void store.settle());
    this.picture.addEventListener("keydown", (e) => this.step(e));
    store.on(["pose", "look"], () => this.draw());
    store.on(["settled"], () => this.follow());
  }

  /** Joints that can be drivers; the panel is there if two freedoms are left, or more, which the server refuses with what to hold. */
  private choices(): number[] {
    return this.store.model.coordinates.flatMap((c, i) => (c.held ? [] : [i]));
  }

  /** The chosen drivers, as long as they are free; else the actuators, or the first two free joints. */
  private chooseDrivers(): void {
    const { model } = this.store, free = this.choices(), own = model.actuators.filter((c) => free.includes(c));
    if (!this.drivers || this.drivers.some((c) => !free.includes(c))) this.drivers = own.length === 2 ? [own[0], own[1]] : [free[0], free[1]];
  }

  node(): HTMLElement | null {
    const { store } = this, { model } = store, free = this.choices();
    this.chooseDrivers();
    if (store.link.recorded || store.pose.mobility < 2 || !model.substructures.some((s) => s.loops > 0)) return null;
    const chooser = (d: 0 | 1): HTMLElement => {
      const choice = el("select", { "aria-label": `Driver ${d ? "upwards" : "across"}`, onchange: () => {
        this.drivers![d] = Number(choice.value);
        this.again();
      } }, ...free.map((c) => el("option", { value: c, selected: c === this.drivers![d], text: model.coordinates[c].label })));
      return choice;
    };
    const find = this.working
      ? button("Stop", "Stop finding the map", () => (this.stopped = true))
      : button(this.map ? "Again" : "Find", "Find the configurations over both drivers", () => void this.find());
    return el("div", { class: "group" }, el("h2", { text: "Map over two drivers" }),
      el("div", { class: "chips" }, chooser(0), chooser(1), this.pointChoice(), find), this.working ? this.bar : null,
      ...(this.map ? [el("div", { class: "chips" }, this.columnChoice(this.map.cells), this.overChoice(), ...this.parts(this.map.cells)), this.picture as HTMLElement, this.colours] : []));
  }

  private pointChoice(): HTMLElement {
    const { model } = this.store, frames = model.frames.map((f, i) => ({ f, i })).filter(({ f }) => f.body > 0 && f.name !== "origin");
    if (!frames.some(({ i }) => i === this.frame)) this.frame = -1;
    const choice = el("select", { "aria-label": "Point whose workspace is found", onchange: () => {
      this.frame = Number(choice.value);
      this.isOverPoint = true;
      this.again();
    } }, el("option", { value: -1, text: "no point" }), ...frames.map(({ f, i }) => el("option", { value: i, selected: i === this.frame, text: `${model.bodies[f.body].name}/${f.name}` })));
    return choice;
  }

  private overChoice(): HTMLElement | null {
    if (!this.map?.boundary) return null;
    return el("button", { type: "button", class: "chip", "aria-pressed": String(this.isOverPoint), onclick: () => {
      this.isOverPoint = !this.isOverPoint;
      this.show();
    } }, "over the point");
  }

  private columnChoice(cells: Table): HTMLElement {
    const names = cells.columns.map((c) => c.name).filter((name) => /^(m|sigma)\.|^manipulability$/.test(name));
    if (!names.includes(this.column)) this.column = "sigma.input";
    const choice = el("select", { "aria-label": "Column of the colours", onchange: () => {
      this.column = choice.value;
      this.draw();
    } }, ...names.map((name) => el("option", { value: name, selected: name === this.column, text: name })));
    return choice;
  }

  private parts(cells: Table): HTMLElement[] {
    const { part } = this.axes!, numbers = Array.from(new Set(cells.values[part])).filter((n) => n > 0).sort((a, b) => a - b);
    return numbers.map((n) => el("button", { type: "button", class: "chip", "aria-pressed": String(n === this.part), onclick: () => {
      this.part = n;
      this.changed();
      this.draw();
    } }, `${cells.columns[part].name} ${n}`));
  }

  /** Another map is wanted. */
  private again(): void {
    if (this.working) this.stopped = true;
    else if (this.map) void this.find();
  }

  /** Finds a coarse map, then a fine one; anew where the design, the drivers or the point have changed meanwhile. */
  private async find(): Promise<void> {
    const { store } = this, wanted = (): string => [store.revision, ...this.drivers!, this.frame].join();
    if (this.working) return;
    this.working = true;
    this.chooseDrivers();
    for (let asked = ""; asked !== wanted(); ) {
      asked = wanted();
      this.stopped = false;
      this.revision = store.revision;
      await this.findBoth();
    }
    this.working = false;
    this.changed();
    this.draw();
  }

  private async findBoth(): Promise<void> {
    const { store, frame } = this, drivers: [number, number] = [...this.drivers!], ranges = drivers.map((c) => rangeOf(store, c, store.pose.q[c]));
    for (const [turn, steps] of STEPS.entries()) {
      this.changed();
      const cells = await this.wait(`mapping ${drivers.join(" ")} ${ranges.flat().join(" ")} ${steps}${frame < 0 ? "" : ` ${frame}`}`);
      if (this.stopped && turn > 0) return store.say("The finer map was stopped.");
      if (cells.kind !== "table") {
        if (this.stopped) store.say("The map was stopped.");
        else if (cells.kind === "error" && store.revision === this.revision) store.say(cells.text, true);
        return;
      }
      const curves = await store.link.ask("singular"), boundary = frame < 0 ? null : await store.link.ask("boundary");
      if (curves.kind !== "table" || store.revision !== this.revision) return; // the design has changed meanwhile
      this.map = { drivers, low: ranges.map((r) => r[0]), high: ranges.map((r) => r[1]), steps, cells, curves, frame, boundary: boundary?.kind === "table" ? boundary : null };
      if (cells.notes.length) store.say(cells.notes[0]);
      this.show();
      if (this.stopped) return;
    }
  }

  /** The cells of a map, when it is found or stopped. */
  private async wait(words: string): Promise<Answer> {
    const { link } = this.store;
    let answer = await link.ask(words);
    for (let pause = PAUSES[0]; answer.kind === "mapping"; pause = Math.min(PAUSES[1], 2 * pause)) {
      if (answer.done > 0) this.bar.value = answer.done;
      else this.bar.removeAttribute("value"); // the share of a search that has just begun isn't known
      await new Promise((done) => setTimeout(done, pause));
      answer = await link.ask(this.stopped ? "stop" : "mapped");
    }
    return answer;
  }

  private show(): void {
    const map = this.map!;
    this.axes = map.boundary && this.isOverPoint ? overPoint(map) : overDrivers(map);
    this.part = this.presentPart();
    this.changed();
    this.draw();
  }

  /** After a gesture: another design has another map, and another mode is on another sheet. */
  private follow(): void {
    if (!this.map || this.working) return;
    if (this.store.revision !== this.revision) return void this.find();
    const part = this.presentPart();
    if (part === this.part) return this.draw();
    this.part = part;
    this.changed();
    this.draw();
  }

  private turn(coordinate: number): number {
    const { unit } = this.store.model.coordinates[coordinate];
    return unit === "rad" ? 2 * Math.PI : unit === "deg" ? 360 : 0;
  }

  /** The row of the part (0: of any) whose columns are nearest to the numbers; hinges count no full turns. */
  private nearest(part: number, coordinates: number[], wanted: ArrayLike<number>): number {
    const { cells } = this.map!, { model } = this.store, parts = cells.values[this.axes!.part];
    const columns = coordinates.map((c) => columnOf(cells, `q.${model.coordinates[c].label}`));
    let best = -1, least = Infinity;
    for (let r = 0; r < parts.length; ++r) {
      if (part ? parts[r] !== part : parts[r] <= 0) continue;
      let sum = 0;
      coordinates.forEach((c, k) => {
        const column = columns[k], turn = this.turn(c);
        if (!column) return;
        const d = column[r] - wanted[c];
        sum += (turn ? ((d - turn * Math.round(d / turn)) * 2 * Math.PI) / turn : d / model.length) ** 2;
      });
      if (sum < least) [best, least] = [r, sum];
    }
    return best;
  }

  /** The row of the part that is nearest to a place of the picture. */
  private nearestPlace(at: [number, number]): number {
    const { x, y, part } = this.axes!, parts = this.map!.cells.values[part];
    let best = -1, least = Infinity;
    for (let r = 0; r < parts.length; ++r) {
      const d = (x[r] - at[0]) ** 2 + (y[r] - at[1]) ** 2;
      if (parts[r] === this.part && d < least) [best, least] = [r, d];
    }
    return best;
  }

  private presentPart(): number {
    const row = this.nearest(0, this.choices(), this.store.pose.q);
    return row < 0 ? 1 : this.map!.cells.values[this.axes!.part][row];
  }

  /** Goes to the configuration of the part that is nearest to a place of the picture; the loops close next to it. */
  private go(at: [number, number]): void {
    const { store } = this, map = this.map!, wanted = Float64Array.from(store.pose.q);
    map.drivers.forEach((c, d) => (wanted[c] = at[d]));
    const row = this.axes!.isPoint ? this.nearestPlace(at) : this.nearest(this.part, map.drivers, wanted);
    if (row < 0) return;
    const q = store.model.coordinates.map((c, i) => columnOf(map.cells, `q.${c.label}`)?.[row] ?? store.pose.q[i]);
    const cell = map.drivers.map((_, d) => (map.high[d] - map.low[d]) / map.steps);
    if (!this.axes!.isPoint && map.drivers.every((c, d) => Math.abs(at[d] - q[c]) <= cell[d])) map.drivers.forEach((c, d) => (q[c] = at[d])); // within the grid's step
    store.pull(`place ${q.join(" ")}`, () => false);
  }

  private point(e: PointerEvent): void {
    const { low, high } = this.axes!, box = this.picture.getBoundingClientRect();
    const part = [(e.clientX - box.left) / box.width, 1 - (e.clientY - box.top) / box.height];
    this.go(part.map((p, d) => low[d] + p * (high[d] - low[d])) as [number, number]);
  }

  private step(e: KeyboardEvent): void {
    const by: Record<string, [number, number]> = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowDown: [0, -1], ArrowUp: [0, 1] };
    const move = by[e.key];
    if (!move || !this.map) return;
    e.preventDefault();
    e.stopPropagation();
    const { low, high, isPoint } = this.axes!, at = this.present(), steps = isPoint ? 0.5 * this.map.steps : this.map.steps;
    this.go(at.map((v, d) => v + (move[d] * (high[d] - low[d])) / steps) as [number, number]);
    void this.store.settle();
  }

  /** Where the pose is in the picture: the drivers, hinges within the range as far as full turns lead there, or the nearest cell's place of the point. */
  private present(): [number, number] {
    const map = this.map!, axes = this.axes!;
    if (axes.isPoint) {
      const row = this.nearest(0, this.choices(), this.store.pose.q);
      return row < 0 ? [NaN, NaN] : [axes.x[row], axes.y[row]];
    }
    return map.drivers.map((c, d) => {
      const turn = this.turn(c), q = this.store.pose.q[c];
      return turn ? q - turn * Math.round((q - 0.5 * (map.low[d] + map.high[d])) / turn) : q;
    }) as [number, number];
  }

  private draw(): void {
    const { map, axes } = this, context = this.picture.getContext("2d");
    if (!map || !axes || !context || !this.picture.isConnected) return;
    const [low, high] = drawMap(context, map, axes, this.part, this.column, this.present());
    const units = axes.names.map((name) => map.cells.columns.find((c) => c.name === name)!.unit);
    const names = axes.names.map((name, d) => `${name.replace(/^q\./, "")} ${shown(axes.low[d])} … ${shown(axes.high[d])} ${units[d]}`);
    const part = `${map.cells.columns[axes.part].name} ${this.part}`;
    const lines = axes.isPoint ? `Workspace: ${map.boundary!.notes[0]}. Red, dashed: the point can't move in some direction; grey: a limit. ` : "";
    this.picture.setAttribute("aria-label", `Map of ${this.column} on ${part}: across ${names[0]}, upwards ${names[1]}. Arrow keys move the ${axes.isPoint ? "point" : "drivers"}.`);
    this.colours.textContent = `Across ${names[0]}, upwards ${names[1]}. ${this.column}: dark ${shown(low, 3)}, light ${shown(high, 3)}. Black and white lines: the drivers are singular. ${lines}Click to go there.`;
  }
}
