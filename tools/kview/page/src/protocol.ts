// What the server and the page tell each other (docs/kview-protocol.md).

export const PROTOCOL = 1;

export interface Body { name: string; assembly: number; patches: number; mass: number; center: number[] }
export interface Frame { name: string; body: number; R: number[]; T: number[]; file?: number[] }
export interface Joint { label: string; type: string; frames: [number, number]; first: number; count: number }
export interface Coordinate {
  label: string; unit: string; push: string; joint: number; substructure: number; held: boolean; low: number | null; high: number | null;
}
export interface Substructure { loops: number; rank: number; mobility: number; coordinates: number }
export interface Parameter { name: string; note: string; value: number; file: number; low: number | null; high: number | null }
export interface Model {
  kind: "model"; request: number; version: string; name: string; meters: number; force: string; length: number;
  kutzbach: number; kutzbachPlanar: number; kutzbachExtended: number; redundant: number; edited: boolean; normal?: number[];
  assemblies: { name: string; parent: number }[];
  bodies: Body[]; frames: Frame[]; joints: Joint[]; coordinates: Coordinate[]; substructures: Substructure[];
  sweep: { driver: number; from: number; to: number; steps: number; arclength: number };
  input: number; output: number; loads: number; actuators: number[]; poses: string[]; questions: string[]; parameters: Parameter[]; notes: string[];
}

export const STOPS = ["free", "limit", "toggle", "nearest"] as const;
export interface Pose {
  kind: "pose"; request: number; stop: (typeof STOPS)[number]; coordinate: number; there: boolean; edited: boolean;
  canUndo: boolean; canRedo: boolean; mobility: number; left: number; residual: number;
  q: Float64Array; m: Float64Array; bodies: Float32Array; // 12 a body: R by rows, p
}

export interface Column { name: string; unit: string }
export interface Event { name: string; subject: string; s: number | null; value: number | null }
export interface Table {
  kind: "table"; request: number; question: string; driver: number; branches: number; stopped?: string; columns: Column[]; events: Event[]; notes: string[];
  values: Float64Array[]; // by column
}
export interface Patch {
  kind: "patch"; request: number; body: number; color: number[]; vertices: Float32Array; triangles: Uint32Array;
}
export interface Track {
  kind: "track"; request: number; coordinate: number; low: number; high: number;
  events: { name: string; subject: string; own: boolean; s: number | null }[];
}
export interface Motions { kind: "motions"; request: number; freedom: number; motions: { rates: number[]; twists: number[][] }[] }
export interface Redundancy {
  rotation: boolean; loop: number; loops: number; outOfPlane: boolean; lasting: boolean; direction: number[]; point: number[];
  remedies: { joint: string; index: number; to: string }[];
}
export interface Diagnosis { kind: "diagnosis"; request: number; finite: number; undecided: boolean; redundancies: Redundancy[] }
export interface Forces {
  kind: "forces"; request: number; held: boolean; degree: number; loads: { name: string; point: number[]; force: number[] }[];
  actuators: { coordinate: number; force: number | null }[]; leastNorm: number[];
  reactions: { point: number[]; force: number[]; torque: number[] }[];
}
export interface Lever { kind: "lever"; request: number; state: string; unit: string; value: number | null }
export interface Modes { kind: "modes"; request: number; count: number; isolated: boolean }
export interface SelfMotion { kind: "selfmotion"; request: number; whole: boolean; coordinates: number[]; u: number[]; arc: number[]; q: number[][] }
/** Rates of an arm's joints: the path-control column, then the pose-control columns. */
export interface Columns { kind: "columns"; request: number; entry: number; coordinates: number[]; columns: number[][] }
/** How far a map is that is being found. */
export interface Mapping { kind: "mapping"; request: number; done: number }
export interface File { kind: "file"; request: number; text: string }
export interface Failure { kind: "error"; request: number; text: string }
export type Answer =
  | Model | Pose | Table | Patch | Track | Motions | Diagnosis | Forces | Lever | Modes | SelfMotion | Columns | Mapping | File | Failure;

function pose(data: DataView): Pose {
  const n = data.getUint32(8, true), bodies = data.getUint32(12, true), flags = data.getUint32(24, true);
  const start = 48, numbers = new Float64Array(2 * n), places = new Float32Array(12 * bodies);
  for (let k = 0; k < 2 * n; ++k) numbers[k] = data.getFloat64(start + 8 * k, true);
  for (let k = 0; k < 12 * bodies; ++k) places[k] = data.getFloat32(start + 16 * n + 4 * k, true);
  return {
    kind: "pose", request: data.getUint32(4, true), stop: STOPS[data.getUint32(16, true)] ?? "free",
    coordinate: data.getInt32(20, true), there: !!(flags & 1), edited: !!(flags & 2), canUndo: !!(flags & 4),
    canRedo: !!(flags & 8), mobility: data.getInt32(28, true), left: data.getFloat64(32, true),
    residual: data.getFloat64(40, true), q: numbers.subarray(0, n), m: numbers.subarray(n), bodies: places,
  };
}

/** How long one pose is in a row of them. */
export function poseSize(data: DataView): number {
  return 48 + 16 * data.getUint32(8, true) + 48 * data.getUint32(12, true);
}

function patch(data: DataView): Patch {
  const vertices = data.getUint32(12, true), triangles = data.getUint32(16, true), start = 36;
  const color = [0, 1, 2, 3].map((k) => data.getFloat32(20 + 4 * k, true));
  const points = new Float32Array(3 * vertices), corners = new Uint32Array(3 * triangles);
  for (let k = 0; k < points.length; ++k) points[k] = data.getFloat32(start + 4 * k, true);
  for (let k = 0; k < corners.length; ++k) corners[k] = data.getUint32(start + 4 * (points.length + k), true);
  return { kind: "patch", request: data.getUint32(4, true), body: data.getUint32(8, true), color, vertices: points, triangles: corners };
}

function table(data: DataView): Table {
  const size = data.getUint32(8, true), rows = data.getUint32(12, true), columns = data.getUint32(16, true);
  const text = new TextDecoder().decode(new Uint8Array(data.buffer, data.byteOffset + 20, size));
  const values = Array.from({ length: columns }, () => new Float64Array(rows));
  for (let r = 0; r < rows; ++r)
    for (let c = 0; c < columns; ++c) values[c][r] = data.getFloat64(20 + size + 8 * (r * columns + c), true);
  return { kind: "table", request: data.getUint32(4, true), ...JSON.parse(text), values };
}

export function decode(message: ArrayBuffer | string): Answer {
  if (typeof message === "string") return JSON.parse(message) as Answer;
  const data = new DataView(message), kind = data.getUint32(0, true);
  return kind === 1 ? pose(data) : kind === 2 ? patch(data) : table(data);
}
