// The bar on top: views, colours, hand or design, undo, theme.
import { button, el } from "../dom";
import { ColourBy, Store } from "../store";
import { Side, View } from "../view/view";

export class Toolbar {
  readonly node = el("header", { class: "bar" });
  private title = el("strong");
  private undo = button("↶", "Undo (Ctrl+Z)", () => void this.step(-1));
  private redo = button("↷", "Redo (Ctrl+Shift+Z)", () => void this.step(1));
  private poses = el("select", { "aria-label": "Poses of the model", title: "Go to a pose that the model names", hidden: true, onchange: () => void this.goToPose() });
  private mobility = el("span", { class: "badge", title: "Mobility at this pose" });
  private design = el("button", { type: "button", "aria-pressed": "false", title: "Drag pivots instead of bodies: the links change (D)", onclick: () => this.toggleDesign() }, "Design");

  constructor(private store: Store, private view: View) {
    const colour = el("select", { "aria-label": "Colours", onchange: () => {
      store.colourBy = colour.value as ColourBy;
      store.tell("look");
    } }, ...([["bodies", "Bodies"], ["substructures", "Substructures"], ["mobility", "Mobility numbers"]] as const).map(([v, t]) => el("option", { value: v, text: t })));
    const sides: [Side, string, string][] = [["fit", "Fit", "Fit the mechanism into the view (F)"], ["xy", "xy", "Look at the xy plane (1)"], ["xz", "xz", "Look at the xz plane (2)"], ["yz", "yz", "Look at the yz plane (3)"], ["iso", "iso", "Look from above and aside (4)"]];
    const toggle = (text: string, name: string, get: () => boolean, set: (on: boolean) => void): HTMLElement => {
      const node = el("button", { type: "button", title: name, "aria-label": name, "aria-pressed": String(get()), onclick: () => {
        set(!get());
        node.setAttribute("aria-pressed", String(get()));
        store.tell("look");
      } }, text);
      return node;
    };
    this.node.append(
      this.title, this.mobility,
      el("div", { class: "set", role: "group", "aria-label": "Steps" }, this.undo, this.redo),
      el("div", { class: "set", role: "group", "aria-label": "View" }, ...sides.map(([side, text, name]) => button(text, name, () => view.see(side)))),
      el("label", { class: "colour" }, "Colours ", colour),
      el("div", { class: "set", role: "group", "aria-label": "Show" },
        toggle("Names", "Names of joints (N)", () => store.labels, (on) => (store.labels = on)),
        toggle("Frames", "Axes of bodies: x red, y green, z blue", () => store.frames, (on) => (store.frames = on))),
      this.design, this.poses,
      button("Copy pose", "Copy the pose as --set arguments", () => void this.copyPose()),
      button("◐", "Light or dark", () => this.theme(), { class: "theme" }),
    );
    store.on(["model"], () => this.follow());
    store.on(["pose"], () => this.follow());
  }

  private follow(): void {
    const { model, pose, link } = this.store;
    this.title.textContent = model.name + (model.edited ? " *" : "");
    document.title = `${model.name} – kview`;
    this.fillPoses();
    if (!pose) return;
    this.mobility.textContent = `M = ${pose.mobility}`;
    this.undo.disabled = !pose.canUndo || link.recorded;
    this.redo.disabled = !pose.canRedo || link.recorded;
    this.design.hidden = link.recorded;
  }

  private fillPoses(): void {
    const { poses } = this.store.model;
    this.poses.hidden = !poses.length || this.store.link.recorded;
    if (this.poses.dataset.names === poses.join("\n")) return;
    this.poses.dataset.names = poses.join("\n");
    this.poses.replaceChildren(el("option", { value: "", text: "Pose …" }), ...poses.map((name, i) => el("option", { value: i, text: name })));
  }

  /** The menu shows its title again, so that the same pose can be chosen once more. */
  private async goToPose(): Promise<void> {
    const { store } = this, choice = this.poses.value, name = store.model.poses[Number(choice)];
    this.poses.value = "";
    if (choice === "" || (await store.ask(`named ${choice}`)).kind === "error") return;
    await store.settle();
    store.say(`The pose "${name}" of the model.`);
  }

  async step(direction: number): Promise<void> {
    const { store } = this, edited = store.model.edited;
    await store.ask(`undo ${direction}`);
    if (edited || store.pose.edited) {
      await store.ask("hello 1");
      await store.ask("pose");
      if (store.table) await store.ask("again");
    }
  }

  toggleDesign(): void {
    const { store } = this;
    if (store.link.recorded) return;
    store.mode = store.mode === "move" ? "design" : "move";
    this.design.setAttribute("aria-pressed", String(store.mode === "design"));
    document.documentElement.dataset.mode = store.mode;
    store.say(store.mode === "design" ? "Design: drag a joint to another place; the curve follows." : "");
    store.tell("selection");
  }

  /** Joints whose values say the pose: pivots of the instantaneous motions, hinges and slides before balls, which are set as a whole. */
  private async independent(): Promise<Set<number>> {
    const { model, link } = this.store, out = new Set<number>();
    const answer = link.recorded ? null : await link.ask("motions");
    const rows = answer?.kind === "motions" && answer.motions.length === answer.freedom ? answer.motions.map((m) => [...m.rates]) : null;
    if (!rows) return new Set(model.joints.keys());
    const single = model.coordinates.map((c) => model.joints[c.joint].count === 1);
    for (const wanted of [true, false])
      for (;;) {
        let best = -1, at = -1, size = 1e-6;
        for (let r = 0; r < rows.length; ++r)
          rows[r].forEach((x, c) => {
            if (single[c] === wanted && Math.abs(x) > size) [best, at, size] = [r, c, Math.abs(x)];
          });
        if (best < 0) break;
        const [pivot] = rows.splice(best, 1);
        for (const row of rows) {
          const share = row[at] / pivot[at];
          row.forEach((_, c) => (row[c] -= share * pivot[c]));
        }
        out.add(model.coordinates[at].joint);
      }
    return out;
  }

  private async copyPose(): Promise<void> {
    const { model, pose } = this.store;
    const quoted = (label: string): string => (/^[\w.-]+$/.test(label) ? label : `'${label.replace(/([,=/[\\])/g, "\\$1").replace(/'/g, "'\\''")}'`);
    const independent = await this.independent();
    const joint = model.joints.filter((j, i) => j.count && !model.coordinates[j.first].held && independent.has(i));
    const words = joint.map((j) => `--set ${quoted(j.label)}=${Array.from(pose.q.subarray(j.first, j.first + j.count)).join(",")}`).join(" ");
    try {
      await navigator.clipboard.writeText(words);
      this.store.say("The pose is copied as --set arguments.");
    } catch {
      this.store.say(words);
    }
  }

  theme(): void {
    const { dataset } = document.documentElement;
    dataset.theme = dataset.theme === "dark" ? "light" : "dark";
    this.store.tell("look");
    this.view.themed();
  }
}
