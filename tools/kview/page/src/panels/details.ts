// What is known of the selection and of the whole, and why it moves as it does.
import { button, el, replace, shown, typed } from "../dom";
import { OKABE, scaleColour } from "../palette";
import { Forces } from "../protocol";
import { Store } from "../store";
import { ArmPanel } from "./arm";
import { parameters, variants } from "./design";
import { MapPanel } from "./map";
import { typeOf } from "./tree";

type Fact = [string, string | HTMLElement];

function facts(list: Fact[]): HTMLElement {
  return el("dl", {}, ...list.flatMap(([name, value]) => [el("dt", { text: name }), el("dd", {}, value)]));
}

export class Details {
  readonly node = el("section", { class: "panel details", "aria-label": "Details" });
  private whole = el("div");
  private chosen = el("div");
  private why = el("div", { class: "why" });
  private lever = el("output", { class: "big" });
  private stamp = "";
  private arm = new ArmPanel(this.store, () => this.explain());
  private map = new MapPanel(this.store, () => this.explain());

  constructor(private store: Store, private stopSwing: () => void) {
    this.node.append(this.whole, this.chosen, this.why);
    store.on(["model", "selection"], () => this.build());
    store.on(["pose"], () => this.follow());
    store.on(["why", "variants", "look", "table"], () => this.explain());
  }

  private unit(): string {
    const meters = this.store.model.meters;
    return meters === 1 ? "m" : meters === 0.001 ? "mm" : meters === 0.01 ? "cm" : meters === 0.0254 ? "in" : "";
  }

  private build(): void {
    if (!this.store.pose) return;
    this.follow();
    this.explain();
  }

  private follow(): void {
    const { model, pose } = this.store;
    if (!pose || pose.q.length !== model.coordinates.length) return;
    const numbers: Fact[] = [
      ["Mobility here", el("b", { text: String(pose.mobility) })],
      ["Kutzbach", String(model.normal ? model.kutzbachPlanar : model.kutzbach) + (model.normal ? " (planar)" : "")],
      ["Redundant constraints", String(model.redundant)],
      ["Loops closed to", pose.residual.toExponential(1).replace("-", "−")],
    ];
    replace(this.whole, el("h2", { text: "Mechanism" }), facts(numbers));
    const editing = this.chosen.contains(document.activeElement) && document.activeElement instanceof HTMLInputElement;
    if (!editing) this.showChosen();
    this.refreshAnswers();
  }

  private showChosen(): void {
    const { selection } = this.store;
    if (!selection) replace(this.chosen, el("p", { class: "hint", text: "Drag a body or a slider. Click a joint or a body to see more of it." }));
    else if (selection.kind === "joint") this.showJoint(selection.index);
    else this.showBody(selection.index);
  }

  private showJoint(j: number): void {
    const { model, pose } = this.store, joint = model.joints[j], { word } = typeOf(joint);
    const ends = joint.frames.map((f) => `${model.bodies[model.frames[f].body].name} / ${model.frames[f].name}`);
    const list: Fact[] = [["Type", `${word} ${joint.type}`], ["From", ends[0]], ["To", ends[1]]];
    for (let k = 0; k < joint.count; ++k) {
      const c = model.coordinates[joint.first + k];
      list.push([c.label, `${shown(pose.q[joint.first + k], 6)} ${c.unit}${c.held ? ", held" : ""}`]);
      list.push(["Mobility number", el("span", {}, el("span", { class: "dot", style: `background:${scaleColour(pose.m[joint.first + k])}` }), pose.m[joint.first + k].toFixed(6))]);
      if (c.low !== null || c.high !== null) list.push(["Limits", `${c.low === null ? "−∞" : shown(c.low)} … ${c.high === null ? "∞" : shown(c.high)} ${c.unit}`]);
      list.push(["Substructure", c.substructure < 0 ? "none: in no loop" : String(c.substructure + 1)]);
    }
    replace(this.chosen, el("h2", { text: `Joint ${joint.label}` }), facts(list), this.store.mode === "design" ? this.pivot(j) : null);
  }

  /** The joint's place, typed. */
  private pivot(j: number): HTMLElement {
    const { store } = this, { model, pose } = store, frame = model.frames[model.joints[j].frames[1]], b = 12 * frame.body;
    const at = [0, 1, 2].map((i) => [0, 1, 2].reduce((s, k) => s + pose.bodies[b + 3 * i + k] * frame.T[k], pose.bodies[b + 9 + i]));
    const fields = at.map((x, i) => el("input", { type: "text", inputmode: "decimal", "aria-label": `${"xyz"[i]} of the pivot`, value: shown(x, 6), onchange: () => void move() }));
    const move = async (): Promise<void> => {
      const numbers = fields.map((f) => typed(f.value));
      if (numbers.every(Number.isFinite) && (await store.ask(`pivot ${j} ${numbers.join(" ")}`)).kind !== "error") {
        await store.ask("pose");
        await store.ask("again");
        await store.settle();
      }
    };
    return el("div", { class: "pivot" }, el("h3", { text: `Place in this pose, ${this.unit()}` }), ...fields);
  }

  private showBody(b: number): void {
    const { model } = this.store, body = model.bodies[b];
    const joints = model.joints.filter((j) => j.frames.some((f) => model.frames[f].body === b)).map((j) => j.label);
    const frames = model.frames.filter((f) => f.body === b && f.name !== "origin").map((f) => f.name);
    const list: Fact[] = [["Joints", joints.join(", ") || "none"], ["Frames", frames.join(", ") || "none"]];
    if (body.mass > 0) list.push(["Mass", shown(body.mass)]);
    replace(this.chosen, el("h2", { text: b === 0 ? "The inertial frame" : `Body ${body.name}` }), facts(list), this.store.mode === "design" ? this.dimensions(b) : null);
  }

  /** Places of the body's frames in it, typed. */
  private dimensions(b: number): HTMLElement | null {
    const { store } = this, frames = store.model.frames.map((f, i) => ({ f, i })).filter(({ f }) => f.body === b && f.name !== "origin");
    if (!frames.length) return null;
    const row = ({ f, i }: (typeof frames)[number]): HTMLElement => {
      const fields = f.T.map((x, k) => el("input", { type: "text", inputmode: "decimal", "aria-label": `${"xyz"[k]} of ${f.name}`, value: shown(x, 6), onchange: () => void move() }));
      const move = async (): Promise<void> => {
        const numbers = fields.map((field) => typed(field.value));
        if (!numbers.every(Number.isFinite) || (await store.ask(`frame ${i} ${numbers.join(" ")}`)).kind === "error") return;
        await store.ask("pose");
        if (store.table) await store.ask("again");
        await store.settle();
      };
      return el("div", { class: "pivot" }, el("h3", { text: f.name }), ...fields);
    };
    return el("div", {}, el("h2", { text: `Places in the body, ${this.unit()}` }), ...frames.map(row));
  }

  // Why

  /** Asks again, after a move, what is shown of the pose. */
  private asking = false;
  private refreshAnswers(): void {
    const { store } = this, stamp = Array.from(store.pose.q).join() + store.ends + store.arrows + store.revision + this.arm.wanted();
    if (this.asking || store.link.recorded || stamp === this.stamp) return;
    const asks: string[] = [];
    if (store.arrows) asks.push("forces");
    if (store.ends && store.ends[0] !== store.ends[1]) asks.push(`lever ${store.ends.join(" ")}`);
    if (this.arm.wanted()) asks.push(this.arm.wanted());
    if (!asks.length) return;
    this.stamp = stamp;
    this.asking = true;
    void Promise.all(asks.map((words) => store.ask(words))).then((answers) => {
      this.asking = false;
      if (answers.some((answer, i) => answer.kind === "error" && asks[i] === "forces")) {
        store.forces = null; // those of another pose or model aren't shown
        store.tell("why");
      }
      this.refreshAnswers();
    });
  }

  private explain(): void {
    const { store } = this, { model } = store;
    if (!store.pose) return;
    this.refreshAnswers();
    if (this.why.contains(document.activeElement) && document.activeElement instanceof HTMLInputElement && document.activeElement.type === "text") return;
    const parts: (HTMLElement | null)[] = [];
    if (store.lever && store.ends) {
      const value = store.lever.state === "finite" ? shown(store.lever.value ?? NaN) : store.lever.state;
      this.lever.textContent = `${value} ${store.lever.state === "finite" ? store.lever.unit : ""}`;
      const [input, output] = store.ends.map((c) => model.coordinates[c].label);
      parts.push(el("div", { class: "group" }, el("h2", { text: `Leverage ${input} over ${output}` }), this.lever));
    }
    if (!store.link.recorded) parts.push(parameters(store), this.motions(), this.arm.node(), this.map.node(), this.redundancies(), this.forces(), this.modes(), variants(store));
    replace(this.why, ...parts);
  }

  private motions(): HTMLElement {
    const { store } = this, list = store.motions?.motions ?? [];
    const show = async (): Promise<void> => {
      await store.ask("motions");
      this.swing(0);
    };
    return el("div", { class: "group" }, el("h2", { text: "Instantaneous motions" }), el("div", { class: "chips" },
      store.motion < 0 ? button("Show", "Animate the instantaneous motions", () => void show()) : null,
      ...(store.motion < 0 ? [] : list.map((_, k) => el("button", { type: "button", class: "chip", "aria-pressed": String(store.motion === k), style: `--c:${OKABE[k % OKABE.length]}`, onclick: () => this.swing(k) }, `Motion ${k + 1}`))),
      store.motion >= 0 ? button("Stop", "Stop the animation", () => this.swing(-1)) : null));
  }

  swing(k: number): void {
    this.store.motion = this.store.motions && k < this.store.motions.motions.length ? k : -1;
    if (this.store.motion < 0) this.stopSwing();
    this.explain();
  }

  private redundancies(): HTMLElement {
    const { store } = this, { diagnosis } = store;
    const found = diagnosis?.redundancies.map((r, i) => ({ r, i })) ?? [];
    const named = found.filter(({ r }) => !r.outOfPlane), planar = found.length - named.length;
    const list = named.slice(0, 40).map(({ r, i }) =>
      el("button", { type: "button", class: "finding", "aria-pressed": String(store.redundancy === i), onclick: () => {
        store.redundancy = store.redundancy === i ? -1 : i;
        store.tell("why");
      } }, `Loop ${r.loop + 1}: ${r.rotation ? "rotation" : "translation"} constrained twice${r.lasting ? "" : " (only here)"}`,
      r.remedies.length ? el("small", { text: r.remedies.map((m) => `make ${m.joint} ${m.to}`).join(" or ") }) : null));
    return el("div", { class: "group" }, el("h2", { text: "Redundant constraints" }),
      diagnosis ? null : button("Find", "Find redundant constraints and their remedies", () => void store.ask("diagnose")),
      diagnosis ? el("p", { class: "hint", text: `Finite mobility ${diagnosis.finite}${diagnosis.undecided ? " or more" : ""}. ${found.length ? "" : "No redundant constraint."}${planar ? `${planar} out of the plane, by nature.` : ""}` }) : null,
      ...list);
  }

  private forces(): HTMLElement {
    const { store } = this, { forces, model } = store;
    const list: Fact[] = store.arrows && forces ? forces.actuators.filter((a) => a.force !== null).slice(0, 12).map((a) => [model.coordinates[a.coordinate].label, `${shown(a.force!)} ${model.coordinates[a.coordinate].push}`]) : [];
    return el("div", { class: "group" }, el("h2", { text: "Forces" }),
      el("button", { type: "button", "aria-pressed": String(store.arrows), onclick: () => {
        store.arrows = !store.arrows;
        this.stamp = "";
        this.refreshAnswers();
        store.tell("why");
      } }, store.arrows ? "Hide arrows" : "Show loads and reactions"),
      store.arrows && forces ? el("p", { class: "hint", text: forces.held ? "The actuators hold this pose:" : "The actuators can't hold this pose." }) : null,
      list.length ? facts(list) : null, store.arrows && forces ? this.largest(forces, model.force) : null);
  }

  /** What the arrows' lengths mean: they grow with the square root of the force. */
  private largest(forces: Forces, unit: string): HTMLElement | null {
    const size = (v: number[]): number => Math.hypot(...v);
    const load = Math.max(0, ...forces.loads.map((l) => size(l.force))), reaction = Math.max(0, ...forces.reactions.map((r) => size(r.force)));
    const list: Fact[] = [];
    if (load > 0) list.push(["Largest load", `${shown(load)} ${unit}`]);
    if (reaction > 0) list.push(["Largest reaction", `${shown(reaction)} ${unit}`]);
    return list.length ? facts(list) : null;
  }

  private modeCount = 0;
  private isolated = true;
  private modes(): HTMLElement {
    const { store } = this, driver = store.model.sweep.driver >= 0 ? store.model.sweep.driver : store.model.coordinates.findIndex((c) => c.substructure >= 0 && !c.held);
    const find = async (): Promise<void> => {
      const answer = await store.ask(`modes ${driver}`);
      this.modeCount = answer.kind === "modes" ? answer.count : 0;
      this.isolated = answer.kind !== "modes" || answer.isolated;
      this.explain();
    };
    return el("div", { class: "group" }, el("h2", { text: "Assembly modes" }), el("div", { class: "chips" },
      driver < 0 ? el("p", { class: "hint", text: "No loops." }) : button("Find", "Find the assembly modes", () => void find()),
      ...Array.from({ length: this.modeCount }, (_, k) => button(String(k + 1), `Take assembly mode ${k + 1}`, () => void this.takeMode(k), { class: "chip" }))),
      this.modeCount && !this.isolated ? el("p", { class: "hint", text: "Freedoms are left beside this joint: the modes aren't isolated, and each is one of a continuum. Hold joints to single them out." }) : null);
  }

  /** The pose of a mode; the curve follows, since it belongs to the motion through the pose. */
  private async takeMode(k: number): Promise<void> {
    const { store } = this;
    if ((await store.ask(`mode ${k}`)).kind === "error") return;
    if (store.table) await store.ask("again");
    await store.settle();
  }
}
