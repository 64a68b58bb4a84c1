// What the page knows, and who is told when it changes.
import { Link } from "./link";
import { Answer, Columns, Diagnosis, Failure, Forces, Lever, Model, Motions, Pose, Table } from "./protocol";
import { bodyColours } from "./palette";

export type Selection = { kind: "body" | "joint"; index: number } | null;
export type ColourBy = "bodies" | "substructures" | "mobility";
export type Mode = "move" | "design";
export interface Variant { name: string; places: number[]; parameters: number[]; table: Table | null }

const READ = 2500; // ms that an error stays at least, while poses go on

type Topic = "model" | "pose" | "settled" | "selection" | "table" | "look" | "why" | "variants" | "message";

export class Store {
  model!: Model;
  pose!: Pose;
  selection: Selection = null;
  table: Table | null = null;
  base: Table | null = null; // of the file's own design
  first: number[] = []; // places of the frames as the file has them
  colourBy: ColourBy = "bodies";
  mode: Mode = "move";
  labels = true;
  frames = false;
  arrows = false;
  message = "";
  alert = false;
  saved = false; // the design as it is has been saved as a file
  revision = 0; // of the model: holds, design; what was asked about another one is stale
  motions: Motions | null = null;
  motion = -1; // the one that swings
  diagnosis: Diagnosis | null = null;
  redundancy = -1;
  forces: Forces | null = null;
  lever: Lever | null = null;
  columns: Columns | null = null;
  column = -1; // the one that is shown
  ends: [number, number] | null = null; // input and output of the leverage
  variants: Variant[] = [];
  private listeners = new Map<Topic, (() => void)[]>();
  private pulling = 0; // how many messages a pull has taken; 0: none goes on

  constructor(readonly link: Link) {}

  on(topics: Topic[], told: () => void): void {
    for (const topic of topics) this.listeners.set(topic, [...(this.listeners.get(topic) ?? []), told]);
  }

  tell(...topics: Topic[]): void {
    const told = new Set<() => void>();
    for (const topic of topics) for (const listener of this.listeners.get(topic) ?? []) told.add(listener);
    for (const listener of told) listener();
  }

  private saidAt = 0;
  say(text: string, alert = false): void {
    this.saidAt = performance.now();
    this.message = text;
    this.alert = alert;
    this.tell("message");
  }

  /** Takes an answer in, whatever it is; true unless it is an error. */
  take(answer: Answer): boolean {
    switch (answer.kind) {
      case "error":
        this.say((answer as Failure).text, true);
        return false;
      case "model":
        this.takeModel(answer);
        break;
      case "pose":
        this.pose = answer;
        this.explainStop(answer);
        this.tell("pose");
        break;
      case "table":
        this.table = answer;
        if (!this.model.edited || !this.base || this.base.question !== answer.question) this.base = this.model.edited ? this.base : answer;
        this.tell("table");
        break;
      case "motions":
        this.motions = answer;
        this.tell("why");
        break;
      case "diagnosis":
        this.diagnosis = answer;
        this.redundancy = -1;
        this.tell("why");
        break;
      case "forces":
        this.forces = answer;
        this.tell("why");
        break;
      case "columns":
        this.columns = answer;
        this.column = Math.min(this.column, answer.columns.length - 1);
        this.tell("why");
        break;
      case "lever":
        this.lever = answer;
        this.tell("why");
        break;
    }
    return true;
  }

  private takeModel(model: Model): void {
    this.model = model;
    ++this.revision;
    this.saved = false;
    this.forces = this.lever = this.columns = null; // of another model
    this.first = model.frames.flatMap((f) => f.file ?? f.T);
    if (this.selection && this.selection.index >= (this.selection.kind === "body" ? model.bodies : model.joints).length)
      this.selection = null;
    this.tell("model");
  }

  private explainStop(pose: Pose): void {
    const label = pose.coordinate >= 0 ? this.model.coordinates[pose.coordinate]?.label : "";
    if (pose.stop === "limit") this.say(`${label} is at its limit.`);
    else if (pose.stop === "toggle") this.say(`${label} is at a toggle: its mobility number is 0 here. Move another joint.`);
    else if (pose.stop === "nearest" && !pose.there) this.say("No motion brings the point any nearer.");
    else if (this.message && (!this.alert || performance.now() - this.saidAt > READ)) this.say("");
  }

  async ask(words: string): Promise<Answer> {
    const answer = await this.link.ask(words);
    this.take(answer);
    return answer;
  }

  /** Pulls on until the target is reached, something stops it, or another pull takes its place. */
  pull(words: string, going: () => boolean): void {
    this.pulling = 0;
    const again = (): void =>
      this.link.pull(words, (answer) => {
        const good = this.take(answer);
        if (good && answer.kind === "pose" && !answer.there && answer.stop === "free" && going() && ++this.pulling < 400) again();
      });
    again();
  }

  /** Ends a gesture: undo comes back to before it. */
  async settle(): Promise<void> {
    if (this.link.recorded) return;
    await this.ask("mark");
    this.tell("settled");
  }

  select(selection: Selection): void {
    this.selection = selection;
    this.tell("selection");
  }

  bodyColour(body: number): string {
    return this.colours()[body];
  }

  private colourCache: { model: Model; list: string[] } | null = null;
  private colours(): string[] {
    if (this.colourCache?.model.joints !== this.model.joints)
      this.colourCache = {
        model: this.model,
        list: bodyColours(this.model.bodies.length, this.model.joints.map((j) => [this.model.frames[j.frames[0]].body, this.model.frames[j.frames[1]].body])),
      };
    return this.colourCache.list;
  }
}
