// The way to the engine: requests go one at a time, and of pulls only the newest counts.
import { Answer, Failure, Patch, decode, poseSize } from "./protocol";

export interface Link {
  /** Whether it can only replay what was recorded. */
  readonly recorded: boolean;
  ask(words: string): Promise<Answer>;
  /** A pull: replaces one that waits. */
  pull(words: string, done: (answer: Answer) => void): void;
  onNews(told: (answer: Answer) => void): void;
  onClosed(told: (why: string) => void): void;
  readonly roundTrip: number; // ms, of the last pulls
}

interface Waiting { words: string; done: (answer: Answer) => void }

export class SocketLink implements Link {
  readonly recorded = false;
  roundTrip = 0;
  private socket: WebSocket;
  private queue: Waiting[] = [];
  private newest: Waiting | null = null;
  private current: (Waiting & { id: number; sent: number; pull: boolean }) | null = null;
  private id = 0;
  private news: (answer: Answer) => void = () => {};
  private closed: (why: string) => void = () => {};

  constructor(address: string) {
    this.socket = new WebSocket(address, "kview");
    this.socket.binaryType = "arraybuffer";
    this.socket.onopen = () => this.next();
    this.socket.onclose = (event) => this.closed(event.reason);
    this.socket.onmessage = (event) => this.receive(decode(event.data));
  }

  ask(words: string): Promise<Answer> {
    return new Promise((done) => {
      this.queue.push({ words, done });
      this.next();
    });
  }

  pull(words: string, done: (answer: Answer) => void): void {
    this.newest = { words, done };
    this.next();
  }

  onNews(told: (answer: Answer) => void): void {
    this.news = told;
  }

  onClosed(told: (why: string) => void): void {
    this.closed = told;
  }

  private next(): void {
    if (this.current || this.socket.readyState !== WebSocket.OPEN) return;
    const pull = !this.queue.length, what = this.queue.shift() ?? this.newest;
    if (!what) return;
    if (pull) this.newest = null;
    this.current = { ...what, id: ++this.id, sent: performance.now(), pull };
    this.socket.send(`${this.id} ${what.words}`);
  }

  private receive(answer: Answer): void {
    const current = this.current;
    if (!current || answer.request !== current.id) {
      this.news(answer);
      return;
    }
    this.current = null;
    if (current.pull) this.roundTrip += 0.1 * (performance.now() - current.sent - this.roundTrip);
    current.done(answer);
    this.next();
  }
}

interface Recording { model: unknown; tables: string[]; patches: string[]; poses: string }

function bytes(text: string): ArrayBuffer {
  const raw = atob(text), out = new Uint8Array(raw.length);
  for (let i = 0; i < raw.length; ++i) out[i] = raw.charCodeAt(i);
  return out.buffer;
}

/** Plays what `kview export` wrote into the page. */
export class RecordedLink implements Link {
  readonly recorded = true;
  readonly roundTrip = 0;
  readonly poses: ArrayBuffer[] = [];
  at = 0;

  constructor(private recording: Recording) {
    const all = bytes(recording.poses);
    for (let start = 0; start < all.byteLength; ) {
      const size = poseSize(new DataView(all, start));
      this.poses.push(all.slice(start, start + size));
      start += size;
    }
  }

  ask(words: string): Promise<Answer> {
    const [verb, ...rest] = words.split(" ");
    const none: Failure = { kind: "error", request: 0, text: "this page is a recording" };
    if (verb === "hello") return Promise.resolve(this.recording.model as Answer);
    if (verb === "pose" || verb === "mark") return Promise.resolve(decode(this.poses[this.at]));
    if (verb === "ask") return Promise.resolve(this.table(Number(rest[0])) ?? none);
    if (verb === "patch") return Promise.resolve(this.patch(Number(rest[0]), Number(rest[1])) ?? none);
    return Promise.resolve(none);
  }

  pull(words: string, done: (answer: Answer) => void): void {
    const [verb, number] = words.split(" ");
    if (verb !== "row") return;
    this.at = Math.max(0, Math.min(this.poses.length - 1, Math.round(Number(number))));
    done(decode(this.poses[this.at]));
  }

  onNews(): void {}
  onClosed(): void {}

  private table(kind: number): Answer | undefined {
    const model = this.recording.model as { questions: string[] };
    return this.recording.tables.map((t) => decode(bytes(t))).find((t) => t.kind === "table" && t.question === model.questions[kind]);
  }

  private patch(body: number, part: number): Answer | undefined {
    const own = this.recording.patches.map((p) => decode(bytes(p)) as Patch).filter((p) => p.body === body);
    return own[part];
  }
}

export function openLink(): Link {
  const recording = document.getElementById("recording");
  if (recording) return new RecordedLink(JSON.parse(recording.textContent ?? "{}"));
  return new SocketLink(`ws://${location.host}${location.pathname}ws`);
}
