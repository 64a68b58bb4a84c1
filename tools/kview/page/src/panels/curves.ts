// The curves of a question over its sweep, with a mark at the present pose.
import uPlot from "uplot";
import { button, el, replace, save, shown, typed } from "../dom";
import { RecordedLink } from "../link";
import { DASHES, OKABE } from "../palette";
import { Table } from "../protocol";
import { Store } from "../store";
import { answers, apart, between, rowAt, spread, tamed } from "./rows";
import { rangeOf } from "./tree";

const MOST_LINES = 7;
const WORDS: Record<string, string> = { mobility: "Mobility numbers", advantage: "Mechanical advantage", forces: "Actuator forces", track: "Track of the path study", motion: "Velocities", allowance: "Play that errors need", clearance: "Clearance of bodies" };

export class Curves {
  readonly node = el("section", { class: "panel curves", "aria-label": "Curves" });
  private place = el("div", { class: "plot" });
  private chips = el("div", { class: "chips" });
  private question = el("select", { "aria-label": "Question", onchange: () => this.choose() });
  private driver = el("select", { "aria-label": "Driver", onchange: () => this.choose(true) });
  private ends = el("span", { class: "ends" });
  private input = el("select", { "aria-label": "Input", onchange: () => void this.ask() });
  private output = el("select", { "aria-label": "Output", onchange: () => void this.ask() });
  private from = el("input", { type: "text", inputmode: "decimal", "aria-label": "From", onchange: () => void this.ask() });
  private to = el("input", { type: "text", inputmode: "decimal", "aria-label": "To", onchange: () => void this.ask() });
  private branch = el("select", { "aria-label": "At the branch point", title: "Which motion goes on where several meet", hidden: true, onchange: () => void this.ask() });
  private over = el("label", {}, "over ", this.driver);
  private dots = el("span", { text: "…" });
  private stop = el("p", { class: "hint", role: "status", hidden: true });
  private plot: uPlot | null = null;
  private shown = new Set<string>();
  private filled = "";
  private shape = "";
  private playing = 0;
  private play = button("▶", "Play the motion", () => this.toggle(), { class: "play" });

  constructor(private store: Store) {
    const bar = el("div", { class: "tools" }, this.play, this.question, this.over, this.from, this.dots, this.to, this.ends, this.branch,
      button("CSV", "Save the table", () => this.saveTable(), { class: "small" }));
    this.ends.append(this.input, " / ", this.output);
    this.node.append(bar, this.chips, this.stop, this.place);
    store.on(["model"], () => this.fill());
    store.on(["table", "variants"], () => this.show());
    store.on(["pose"], () => this.plot?.redraw(false, false));
    store.on(["settled"], () => this.renew());
    store.on(["look"], () => this.rebuild());
    new ResizeObserver(() => this.fit()).observe(this.place);
  }

  private fit(): void {
    this.plot?.setSize({ width: this.place.clientWidth, height: Math.max(90, this.place.clientHeight) });
  }

  /** Choices, and the file's own question at first. */
  private fill(): void {
    const { model } = this.store, key = JSON.stringify([model.name, model.coordinates.map((c) => [c.label, c.held])]);
    if (key === this.filled || !this.store.pose) return;
    this.filled = key;
    const free = model.coordinates.flatMap((c, i) => (c.held ? [] : [el("option", { value: i, text: c.label })]));
    const recorded = this.store.link.recorded;
    replace(this.question, ...model.questions.map((q, i) => el("option", { value: i, text: WORDS[q] ?? q })));
    replace(this.driver, el("option", { value: "-1", text: "arc length" }), ...free);
    for (const select of [this.input, this.output]) replace(select, ...free.map((o) => o.cloneNode(true)));
    const { sweep } = model;
    const first = sweep.driver >= 0 ? sweep.driver : sweep.arclength > 0 ? -1 : model.coordinates.findIndex((c) => !c.held);
    this.driver.value = String(first);
    if (model.input >= 0) this.input.value = String(model.input);
    if (model.output >= 0) this.output.value = String(model.output);
    if (model.input >= 0 && model.output >= 0) this.question.value = String(Math.max(0, model.questions.indexOf("advantage")));
    this.setRange(sweep.driver >= 0 && sweep.driver === first ? [sweep.from, sweep.to] : null);
    for (const field of [this.driver, this.input, this.output, this.from, this.to]) field.disabled = recorded;
    void this.ask();
  }

  private setRange(range: [number, number] | null): void {
    const driver = Number(this.driver.value);
    if (driver < 0) {
      const { arclength } = this.store.model.sweep;
      this.from.value = String(arclength > 0 ? arclength : 0.02);
      this.to.value = "";
    } else {
      const [low, high] = range ?? rangeOf(this.store, driver, this.store.pose.q[driver]);
      this.from.value = shown(low, 5);
      this.to.value = shown(high, 5);
    }
    this.to.hidden = driver < 0;
  }

  private choose(driver = false): void {
    if (driver) {
      this.setRange(null);
      this.branch.replaceChildren();
    }
    void this.ask();
  }

  private async ask(): Promise<void> {
    const { store } = this, kind = this.question.value, word = store.model.questions[Number(kind)];
    const track = word === "track", driver = track ? -1 : Number(this.driver.value), own = store.model.sweep;
    for (const part of [this.over, this.from, this.dots]) part.hidden = track;
    this.to.hidden = track || driver < 0;
    const number = (field: HTMLInputElement): number => typed(field.value);
    if (!track && ![this.from, ...(driver < 0 ? [] : [this.to])].every((field) => Number.isFinite(number(field)))) {
      store.say(driver < 0 ? "A step of arc length needs a number." : "The range needs two numbers.", true);
      return;
    }
    this.ends.hidden = word !== "advantage";
    store.ends = word === "advantage" || (store.model.input >= 0 && store.model.output >= 0) ? [Number(this.input.value), Number(this.output.value)] : null;
    store.tell("why");
    const steps = driver < 0 ? Math.min(own.steps || 400, 1000) : store.model.coordinates.length > 500 ? 24 : 200;
    const along = driver < 0 ? Number(this.branch.value) : 0, words = word === "advantage" ? ` ${this.input.value} ${this.output.value}` : along > 1 ? " -1 -1" : "";
    const ends = words + (along > 1 ? ` ${along}` : "");
    store.base = store.model.edited ? store.base : null;
    const answer = await store.ask(`ask ${kind} ${driver} ${track ? 0 : number(this.from)} ${driver < 0 ? 0 : number(this.to)} ${steps}${ends}`);
    if (answer.kind === "error") this.empty(answer.text);
  }

  private empty(text: string): void {
    this.plot?.destroy();
    this.plot = null;
    this.shape = "";
    this.chips.replaceChildren();
    replace(this.place, el("p", { class: "hint", text }));
  }

  /** A new table: the same lines get other numbers, or the plot is made anew. */
  private show(): void {
    const { table } = this.store;
    if (!table) return;
    this.offerBranches(table);
    this.stop.textContent = table.stopped ? `The curve ends early: ${table.stopped}.` : "";
    this.stop.hidden = !table.stopped;
    const columns = answers(table), shape = JSON.stringify([table.question, table.driver, columns.map((c) => table.columns[c]), this.extras().length]);
    if (!columns.length || !table.values[0]?.length) return this.empty("Nothing to show: the sweep has no row.");
    if (shape === this.shape && this.plot) {
      this.plot.setData(this.data());
      return;
    }
    this.shape = shape;
    const held = new Set(this.store.model.coordinates.filter((c) => c.held).map((c) => `m.${c.label}`));
    const lively = columns.filter((c) => !held.has(table.columns[c].name)).sort((a, b) => spread(table.values[b]) - spread(table.values[a]));
    if (table.question === "track") this.shown = new Set(["limit_margin"]); // the others have units and sizes of their own
    else this.shown = new Set(lively.slice(0, MOST_LINES).map((c) => table.columns[c].name));
    this.showChips(columns);
    this.rebuild();
  }

  /** Where motions meet, any of them can go on: the smooth one, or another one ahead or back. */
  private offerBranches(table: Table): void {
    const count = table.driver < 0 && !this.store.link.recorded ? 2 * table.branches - 1 : 0;
    this.branch.hidden = count < 2 && this.branch.options.length < 2;
    if (count <= this.branch.options.length) return;
    const chosen = this.branch.value;
    replace(this.branch, ...Array.from({ length: count }, (_, k) =>
      el("option", { value: k + 1, text: k === 0 ? "branch point: smoothly on" : `branch point: motion ${2 + ((k - 1) >> 1)}, ${k % 2 ? "ahead" : "back"}` })));
    this.branch.value = chosen || "1";
  }

  private showChips(columns: number[]): void {
    const { table } = this.store;
    if (!table) return;
    replace(this.chips, ...(columns.length < 2 ? [] : columns.map((c, i) => {
      const name = table.columns[c].name, label = name.replace(/^(ma|m|f|fbar|objective)\./, "");
      return el("button", { type: "button", class: "chip", "aria-pressed": String(this.shown.has(name)), style: `--c:${OKABE[i % OKABE.length]}`, onclick: () => {
        if (!this.shown.delete(name)) this.shown.add(name);
        this.showChips(columns);
        this.rebuild();
      } }, label);
    })));
  }

  /** Curves of other designs: the file's own, and those kept as variants. */
  private extras(): { name: string; table: Table }[] {
    const { store } = this, { table } = store, out: { name: string; table: Table }[] = [];
    if (!table) return out;
    if (store.model.edited && store.base && store.base !== table && store.base.question === table.question) out.push({ name: "file", table: store.base });
    for (const variant of store.variants) if (variant.table && variant.table !== table && variant.table.question === table.question && variant.table.driver === table.driver) out.push({ name: variant.name, table: variant.table });
    return out;
  }

  private lines(): { column: string; colour: string; dash: number[]; table: Table; label: string; width: number }[] {
    const { table } = this.store;
    if (!table) return [];
    const columns = answers(table), dark = document.documentElement.dataset.theme === "dark", out: ReturnType<Curves["lines"]> = [];
    for (const extra of this.extras())
      columns.forEach((c, i) => {
        const name = table.columns[c].name;
        if (this.shown.has(name)) out.push({ column: name, colour: extra.name === "file" ? (dark ? "#6b7380" : "#b9c0ca") : `${OKABE[i % OKABE.length]}88`, dash: extra.name === "file" ? [] : [6, 5], table: extra.table, label: extra.name, width: 1.5 });
      });
    columns.forEach((c, i) => {
      const name = table.columns[c].name;
      if (this.shown.has(name)) out.push({ column: name, colour: OKABE[i % OKABE.length], dash: DASHES[Math.floor(i / OKABE.length) % DASHES.length], table, label: name.replace(/^(ma|m|f|fbar|objective)\./, ""), width: 2 });
    });
    return out;
  }

  /** All lines over one axis: those of other tables are read off at its places. */
  private data(): uPlot.AlignedData {
    const table = this.store.table!, s = table.values[1];
    const order = s.length > 1 && s[s.length - 1] < s[0] ? Array.from(s.keys()).reverse() : null;
    const sorted = (values: Float64Array): (number | null)[] => {
      const list = Array.from(order ?? values.keys(), (i) => values[i]);
      return list.map((v) => (Number.isFinite(v) ? v : null));
    };
    const own = sorted(s) as number[];
    return [own, ...this.lines().map((line) => {
      const values = line.table.values[line.table.columns.findIndex((c) => c.name === line.column)];
      if (!values) return own.map(() => null);
      return line.table === table ? sorted(values) : own.map((x) => between(line.table.values[1], values, x));
    })] as uPlot.AlignedData;
  }

  private rebuild(): void {
    const { table, model } = this.store;
    if (!table || !this.shape) return;
    this.plot?.destroy();
    this.place.replaceChildren();
    const style = getComputedStyle(document.documentElement), ink = style.getPropertyValue("--ink2").trim(), line = style.getPropertyValue("--line").trim();
    const lines = this.lines(), unit = table.driver >= 0 ? model.coordinates[table.driver].unit : "";
    const axis = { stroke: ink, grid: { stroke: line, width: 1 }, ticks: { stroke: line, width: 1 }, font: "12px system-ui" };
    const numbers = table.question === "mobility";
    this.plot = new uPlot({
      width: this.place.clientWidth || 400, height: Math.max(90, this.place.clientHeight), legend: { show: false }, pxAlign: 0, cursor: { drag: { x: false, y: false } },
      padding: [10, Math.min(90, 16 + 7 * Math.max(0, ...lines.map((l) => l.label.length))), 0, 0],
      scales: { x: { time: false }, y: numbers ? { range: [0, 1.02] } : { range: (_u, low, high) => tamed(low, high, lines) } },
      axes: [
        { ...axis, label: table.driver >= 0 ? `${model.coordinates[table.driver].label} / ${unit}` : "arc length s", labelSize: 18, labelFont: "12px system-ui", size: 34 },
        { ...axis, size: (_u: uPlot, ticks: string[] | null) => Math.max(54, 18 + 7 * Math.max(0, ...(ticks ?? []).map((tick) => tick?.length ?? 0))) }, // numbers of any length
      ],
      series: [{}, ...lines.map((l) => ({ stroke: l.colour, width: l.width, dash: l.dash, points: { show: false }, label: l.label }))],
      hooks: { draw: [(u) => this.drawOver(u, this.lines())] }, // of the table that is shown by then
    }, this.data(), this.place);
    this.plot.over.addEventListener("pointerdown", (e) => this.point(e));
    this.plot.over.addEventListener("pointermove", (e) => e.buttons && this.point(e));
    this.plot.over.addEventListener("pointerup", () => void this.store.settle());
  }

  /** Where the present pose stands on the axis; null: this sweep's axis isn't a coordinate. */
  private present(): number | null {
    const { table, pose, link } = this.store;
    if (!table) return null;
    if (link instanceof RecordedLink) return table.values[1][link.at] ?? null;
    if (table.driver >= 0) return this.isOn(pose.q[table.driver]) ? pose.q[table.driver] : null;
    return this.nearest();
  }

  /** How far the pose is from one of the table, in radians and characteristic lengths; full turns count as none. */
  private distance(value: (column: Float64Array) => number | null): number {
    const { table, pose, model } = this.store;
    let sum = 0;
    model.coordinates.forEach((c, i) => {
      const column = table!.columns.findIndex((k) => k.name === `q.${c.label}`);
      const there = column < 0 || model.joints[c.joint].count > 1 ? null : value(table!.values[column]); // balls: their vectors may differ in a turn
      if (there === null || !Number.isFinite(there)) return;
      const turn = c.unit === "rad" ? 2 * Math.PI : c.unit === "deg" ? 360 : 0;
      let d = there - pose.q[i];
      d = turn ? ((d - turn * Math.round(d / turn)) / turn) * 2 * Math.PI : d / model.length;
      sum = Math.max(sum, Math.abs(d));
    });
    return sum;
  }

  /** Does the curve belong to the pose? Another mode, or another place of what moves freely beside the driver, has another curve. */
  private isOn(s: number): boolean {
    const { table } = this.store, rows = table!.values[1];
    const low = Math.min(...rows), high = Math.max(...rows), step = (high - low) / Math.max(1, rows.length - 1);
    if (!(s >= low - step && s <= high + step)) return false;
    const inside = Math.min(high, Math.max(low, s));
    return this.distance((column) => between(rows, column, inside)) < 0.05;
  }

  /** After a gesture the curve of another mode or configuration is asked for anew. */
  private renew(): void {
    const { table, pose, link } = this.store;
    const apart = !!table && table.driver >= 0 && !link.recorded && !this.isOn(pose.q[table.driver]);
    const low = apart ? Math.min(...table.values[1]) : 0, high = apart ? Math.max(...table.values[1]) : 0;
    if (apart && pose.q[table.driver] >= low && pose.q[table.driver] <= high) void this.store.ask("again");
  }

  /** The row of the table whose coordinates are nearest to the pose; angles count full turns as none. */
  private nearest(): number | null {
    const { table } = this.store;
    if (!table) return null;
    let best = -1, least = Infinity;
    for (let r = 0; r < table.values[0].length; ++r) {
      const apart = this.distance((column) => column[r]);
      if (apart < least) [best, least] = [r, apart];
    }
    return best >= 0 && least < 0.2 ? table.values[1][best] : null;
  }

  private drawOver(u: uPlot, lines: ReturnType<Curves["lines"]>): void {
    const { ctx, bbox } = u, style = getComputedStyle(document.documentElement), scale = window.devicePixelRatio;
    ctx.save();
    ctx.font = `${12 * scale}px system-ui`;
    ctx.textBaseline = "middle";
    ctx.textAlign = "left";
    const ends: { y: number; line: (typeof lines)[number] }[] = [];
    lines.forEach((line, i) => {
      const values = u.data[i + 1] as (number | null)[];
      let last = values.length - 1;
      while (last >= 0 && values[last] === null) --last;
      if (last >= 0 && line.table === this.store.table) ends.push({ y: u.valToPos(values[last]!, "y", true), line });
    });
    for (const { y, line } of apart(ends, 13 * scale, bbox.top + 6 * scale, bbox.top + bbox.height - 4 * scale)) {
      ctx.fillStyle = line.colour;
      ctx.fillText(line.label, bbox.left + bbox.width + 5 * scale, y);
    }
    const toggles = this.store.table?.events.filter((e) => e.s !== null && /toggle|pole|zero|branch/.test(e.name)) ?? [];
    for (const toggle of toggles) {
      const x = u.valToPos(toggle.s!, "x", true);
      ctx.fillStyle = style.getPropertyValue("--warn");
      ctx.beginPath();
      ctx.moveTo(x, bbox.top + bbox.height - 7 * scale);
      ctx.lineTo(x + 4 * scale, bbox.top + bbox.height);
      ctx.lineTo(x - 4 * scale, bbox.top + bbox.height);
      ctx.fill();
    }
    const at = this.present();
    if (at !== null) {
      const x = Math.round(u.valToPos(at, "x", true));
      ctx.strokeStyle = style.getPropertyValue("--ink");
      ctx.lineWidth = 1.5 * scale;
      ctx.setLineDash([]);
      ctx.beginPath();
      ctx.moveTo(x, bbox.top);
      ctx.lineTo(x, bbox.top + bbox.height);
      ctx.stroke();
      lines.forEach((line, i) => {
        if (line.table !== this.store.table) return;
        const y = between(u.data[0] as unknown as Float64Array, u.data[i + 1] as unknown as Float64Array, at);
        if (y === null || x < bbox.left || x > bbox.left + bbox.width) return;
        ctx.fillStyle = line.colour;
        ctx.beginPath();
        ctx.arc(x, u.valToPos(y, "y", true), 3.6 * scale, 0, 7);
        ctx.fill();
      });
    }
    ctx.restore();
  }

  private point(e: PointerEvent): void {
    if (!this.plot) return;
    const box = this.plot.over.getBoundingClientRect();
    this.goTo(this.plot.posToVal(e.clientX - box.left, "x"));
  }

  private goTo(s: number): void {
    const { store } = this, { table, link } = store;
    if (!table || !Number.isFinite(s)) return;
    const row = rowAt(table.values[1], s);
    if (link instanceof RecordedLink) link.pull(`row ${row}`, (answer) => store.take(answer));
    else if (table.driver >= 0) store.pull(`joint ${table.driver} ${Math.max(Math.min(...table.values[1]), Math.min(Math.max(...table.values[1]), s))}`, () => true);
    else this.takeRow(row);
  }

  /** The pose of a row of the table. */
  private takeRow(row: number): void {
    const { store } = this, { table, model } = store;
    if (!table) return;
    const q = model.coordinates.map((c, i) => {
      const column = table.columns.findIndex((k) => k.name === `q.${c.label}`);
      return column < 0 ? store.pose.q[i] : table.values[column][row];
    });
    store.pull(`place ${q.join(" ")}`, () => false);
  }

  /** Goes through the sweep and back. */
  private toggle(): void {
    if (this.playing) {
      cancelAnimationFrame(this.playing);
      this.playing = 0;
      void this.store.settle();
    } else {
      const { table } = this.store;
      if (!table || table.values[1].length < 2) {
        this.store.say("There is no motion to play: the sweep has one pose at most.");
        return;
      }
      const s = table.values[1], rows = s.length, start = performance.now(), begin = rowAt(s, this.present() ?? s[0]);
      const there = (time: number): void => {
        if (this.store.table !== table) return this.toggle(); // another question: its motion isn't this one
        const at = (begin + ((time - start) / 6000) * rows) % (2 * rows - 2), row = at < rows ? at : 2 * rows - 2 - at;
        const low = Math.floor(row), part = row - low;
        if (table.driver >= 0 && !this.store.link.recorded) this.goTo(s[low] + part * ((s[low + 1] ?? s[low]) - s[low]));
        else this.goTo(s[Math.round(row)]);
        this.playing = requestAnimationFrame(there);
      };
      this.playing = requestAnimationFrame(there);
    }
    this.play.textContent = this.playing ? "❚❚" : "▶";
    this.play.setAttribute("aria-label", this.playing ? "Pause" : "Play the motion");
  }

  startStop(): void {
    this.toggle();
  }

  private saveTable(): void {
    const { table, model } = this.store;
    if (!table) return;
    const quoted = (text: string): string => (/[",\n]/.test(text) ? `"${text.replace(/"/g, '""')}"` : text);
    const head = table.columns.map((c) => quoted(c.unit && c.name !== "s" ? `${c.name}_${c.unit}` : c.name)).join(",");
    const rows = Array.from(table.values[0].keys(), (r) => table.values.map((v) => String(v[r]).replace("Infinity", "inf").replace("NaN", "nan")).join(","));
    save(`${model.name.replace(/\.\w+$/, "")}.${table.question}.csv`, [head, ...rows].join("\r\n") + "\r\n", "text/csv");
  }
}
