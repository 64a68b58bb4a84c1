// The map over two drivers beside the mechanism: a column over the grid, the singularity curves, and the present pose.
import { button, el, shown } from "../dom";
import { scaleColour } from "../palette";
import { Table } from "../protocol";
import { Store } from "../store";
import { rangeOf } from "./tree";

const SIZE = 480; // pixels of the picture, which the page scales
const STEPS = [24, 80]; // a first answer, then a fine one
const OUTLIERS = 0.02; // share of the values beyond either end of the colours

interface Answered { drivers: [number, number]; low: number[]; high: number[]; steps: number; cells: Table; curves: Table }

export class MapPanel {
  private map: Answered | null = null;
  private drivers: [number, number] | null = null;
  private column = "sigma.input";
  private sheet = 1;
  private revision = -1; // of the model that the map is of
  private working = false;
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

  node(): HTMLElement | null {
    const { store } = this, { model } = store, free = this.choices();
    if (store.link.recorded || store.pose.mobility < 2 || !model.substructures.some((s) => s.loops > 0)) return null;
    const own = model.actuators.filter((c) => !model.coordinates[c].held);
    if (!this.drivers || this.drivers.some((c) => !free.includes(c))) this.drivers = own.length === 2 ? [own[0], own[1]] : [free[0], free[1]];
    const chooser = (d: 0 | 1): HTMLElement => {
      const choice = el("select", { "aria-label": `Driver ${d ? "upwards" : "across"}`, onchange: () => {
        this.drivers![d] = Number(choice.value);
        if (this.map) void this.find();
      } }, ...free.map((c) => el("option", { value: c, selected: c === this.drivers![d], text: model.coordinates[c].label })));
      return choice;
    };
    return el("div", { class: "group" }, el("h2", { text: "Map over two drivers" }), el("div", { class: "chips" }, chooser(0), chooser(1),
      button(this.map ? "Again" : "Find", "Find the configurations over both drivers", () => void this.find())),
      ...(this.map ? [el("div", { class: "chips" }, this.columnChoice(this.map.cells), ...this.sheets(this.map.cells)), this.picture as HTMLElement, this.colours] : []));
  }

  private columnChoice(cells: Table): HTMLElement {
    const names = cells.columns.map((c) => c.name).filter((name) => /^(m|sigma)\./.test(name));
    const choice = el("select", { "aria-label": "Column of the colours", onchange: () => {
      this.column = choice.value;
      this.draw();
    } }, ...names.map((name) => el("option", { value: name, selected: name === this.column, text: name })));
    return choice;
  }

  private sheets(cells: Table): HTMLElement[] {
    return Array.from(new Set(cells.values[2])).map((sheet) => el("button", { type: "button", class: "chip", "aria-pressed": String(sheet === this.sheet), onclick: () => {
      this.sheet = sheet;
      this.changed();
      this.draw();
    } }, `sheet ${sheet}`));
  }

  private async find(): Promise<void> {
    const { store } = this, drivers: [number, number] = [...this.drivers!];
    if (this.working) return;
    this.working = true;
    this.revision = store.revision;
    const ranges = drivers.map((c) => rangeOf(store, c, store.pose.q[c]));
    for (const steps of STEPS) {
      const cells = await store.link.ask(`map ${drivers.join(" ")} ${ranges.flat().join(" ")} ${steps}`);
      const curves = cells.kind === "table" ? await store.link.ask("singular") : cells;
      if (cells.kind !== "table" || curves.kind !== "table") {
        if (curves.kind === "error") store.say(curves.text, true);
        break;
      }
      this.map = { drivers, low: ranges.map((r) => r[0]), high: ranges.map((r) => r[1]), steps, cells, curves };
      if (cells.notes.length) store.say(cells.notes[0]);
      this.sheet = this.presentSheet();
      this.changed();
      this.draw();
      if (store.revision !== this.revision) break; // the design has changed meanwhile
    }
    this.working = false;
  }

  /** After a gesture: another design has another map, and another mode is on another sheet. */
  private follow(): void {
    if (!this.map) return;
    if (this.store.revision !== this.revision) return void this.find();
    const sheet = this.presentSheet();
    if (sheet === this.sheet) return this.draw();
    this.sheet = sheet;
    this.changed();
    this.draw();
  }

  private turn(coordinate: number): number {
    const { unit } = this.store.model.coordinates[coordinate];
    return unit === "rad" ? 2 * Math.PI : unit === "deg" ? 360 : 0;
  }

  /** The row of the sheet (0: of any) whose columns are nearest to the numbers; hinges count no full turns. */
  private nearest(sheet: number, coordinates: number[], wanted: ArrayLike<number>): number {
    const { cells } = this.map!, { model } = this.store;
    const columns = coordinates.map((c) => cells.values[cells.columns.findIndex((k) => k.name === `q.${model.coordinates[c].label}`)]);
    let best = -1, least = Infinity;
    for (let r = 0; r < cells.values[2].length; ++r) {
      if (sheet && cells.values[2][r] !== sheet) continue;
      let sum = 0;
      coordinates.forEach((c, k) => {
        if (!columns[k]) return;
        const turn = this.turn(c), d = columns[k][r] - wanted[c];
        sum += (turn ? ((d - turn * Math.round(d / turn)) * 2 * Math.PI) / turn : d / model.length) ** 2;
      });
      if (sum < least) [best, least] = [r, sum];
    }
    return best;
  }

  private presentSheet(): number {
    const row = this.nearest(0, this.choices(), this.store.pose.q);
    return row < 0 ? 1 : this.map!.cells.values[2][row];
  }

  /** Goes to the configuration of the sheet that is nearest to values of the drivers; the loops close next to it. */
  private go(at: [number, number]): void {
    const { store } = this, map = this.map!, wanted = Float64Array.from(store.pose.q);
    map.drivers.forEach((c, d) => (wanted[c] = at[d]));
    const row = this.nearest(this.sheet, map.drivers, wanted);
    if (row < 0) return;
    const q = store.model.coordinates.map((c, i) => {
      const column = map.cells.columns.findIndex((k) => k.name === `q.${c.label}`);
      return column < 0 ? store.pose.q[i] : map.cells.values[column][row];
    });
    const cell = map.drivers.map((_, d) => (map.high[d] - map.low[d]) / map.steps);
    if (map.drivers.every((c, d) => Math.abs(at[d] - q[c]) <= cell[d])) map.drivers.forEach((c, d) => (q[c] = at[d])); // within the grid's step
    store.pull(`place ${q.join(" ")}`, () => false);
  }

  private point(e: PointerEvent): void {
    const map = this.map!, box = this.picture.getBoundingClientRect();
    const part = [(e.clientX - box.left) / box.width, 1 - (e.clientY - box.top) / box.height];
    this.go(part.map((p, d) => map.low[d] + p * (map.high[d] - map.low[d])) as [number, number]);
  }

  private step(e: KeyboardEvent): void {
    const by: Record<string, [number, number]> = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowDown: [0, -1], ArrowUp: [0, 1] };
    const move = by[e.key];
    if (!move || !this.map) return;
    e.preventDefault();
    e.stopPropagation();
    const map = this.map, at = this.present();
    this.go(at.map((v, d) => v + (move[d] * (map.high[d] - map.low[d])) / map.steps) as [number, number]);
    void this.store.settle();
  }

  /** The drivers of the pose, hinges within the range as far as full turns lead there. */
  private present(): [number, number] {
    const map = this.map!;
    return map.drivers.map((c, d) => {
      const turn = this.turn(c), q = this.store.pose.q[c];
      return turn ? q - turn * Math.round((q - 0.5 * (map.low[d] + map.high[d])) / turn) : q;
    }) as [number, number];
  }

  private draw(): void {
    const map = this.map, context = this.picture.getContext("2d");
    if (!map || !context || !this.picture.isConnected) return;
    const { model } = this.store, { cells } = map, values = cells.values[cells.columns.findIndex((c) => c.name === this.column)];
    const own = Array.from(cells.values[2].keys()).filter((r) => cells.values[2][r] === this.sheet);
    const sorted = own.map((r) => values[r]).filter(Number.isFinite).sort((a, b) => a - b);
    const low = sorted[Math.floor(OUTLIERS * (sorted.length - 1))] ?? 0, high = sorted[Math.ceil((1 - OUTLIERS) * (sorted.length - 1))] ?? 1;
    const x = (v: number): number => ((v - map.low[0]) / (map.high[0] - map.low[0])) * SIZE, y = (v: number): number => SIZE - ((v - map.low[1]) / (map.high[1] - map.low[1])) * SIZE;
    const side = SIZE / map.steps + 0.7, style = getComputedStyle(document.documentElement);
    context.clearRect(0, 0, SIZE, SIZE);
    for (const r of own) {
      if (!Number.isFinite(values[r])) continue;
      context.fillStyle = scaleColour(high > low ? (values[r] - low) / (high - low) : 1);
      context.fillRect(x(cells.values[0][r]) - 0.5 * side, y(cells.values[1][r]) - 0.5 * side, side, side);
    }
    this.drawCurves(context, x, y);
    const [a, b] = this.present();
    context.lineWidth = 3;
    context.strokeStyle = "#fff";
    context.fillStyle = "#d55e00";
    context.beginPath();
    context.arc(x(a), y(b), 9, 0, 7);
    context.fill();
    context.stroke();
    context.strokeStyle = style.getPropertyValue("--ink2");
    const names = map.drivers.map((c, d) => `${model.coordinates[c].label} ${shown(map.low[d])} … ${shown(map.high[d])} ${model.coordinates[c].unit}`);
    this.picture.setAttribute("aria-label", `Map of ${this.column} on sheet ${this.sheet}: across ${names[0]}, upwards ${names[1]}. Arrow keys move the drivers.`);
    this.colours.textContent = `Across ${names[0]}, upwards ${names[1]}. ${this.column}: dark ${shown(low, 3)}, light ${shown(high, 3)}. Black and white lines: the drivers are singular. Click to go there.`;
  }

  /** The singularity curves, broken where a hinge passes a full turn. */
  private drawCurves(context: CanvasRenderingContext2D, x: (v: number) => number, y: (v: number) => number): void {
    const { curves, drivers } = this.map!, { model } = this.store;
    const [across, upwards] = drivers.map((c) => curves.values[curves.columns.findIndex((k) => k.name === `q.${model.coordinates[c].label}`)]);
    context.beginPath();
    for (let r = 0; r < curves.values[0].length; ++r) {
      const px = x(across[r]), py = y(upwards[r]);
      const joined = r > 0 && curves.values[0][r] === curves.values[0][r - 1] && Math.abs(px - x(across[r - 1])) < SIZE / 4 && Math.abs(py - y(upwards[r - 1])) < SIZE / 4;
      if (joined) context.lineTo(px, py);
      else context.moveTo(px, py);
    }
    context.lineWidth = 5;
    context.strokeStyle = "#fff";
    context.stroke();
    context.lineWidth = 2;
    context.strokeStyle = "#000";
    context.stroke();
  }
}
