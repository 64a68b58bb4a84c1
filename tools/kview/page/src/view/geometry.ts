// Vectors and places of the model as three.js has them.
import { Matrix4, Vector3 } from "three";
import { Frame, Model, Pose } from "../protocol";

export function vector(numbers: ArrayLike<number>, at = 0): Vector3 {
  return new Vector3(numbers[at], numbers[at + 1], numbers[at + 2]);
}

/** Rotation by rows and place as a matrix. */
export function matrix(R: ArrayLike<number>, at: number, T: ArrayLike<number>, from: number, out = new Matrix4()): Matrix4 {
  return out.set(
    R[at], R[at + 1], R[at + 2], T[from],
    R[at + 3], R[at + 4], R[at + 5], T[from + 1],
    R[at + 6], R[at + 7], R[at + 8], T[from + 2],
    0, 0, 0, 1,
  );
}

export function bodyMatrix(pose: Pose, body: number, out = new Matrix4()): Matrix4 {
  return matrix(pose.bodies, 12 * body, pose.bodies, 12 * body + 9, out);
}

export function frameMatrix(frame: Frame): Matrix4 {
  return matrix(frame.R, 0, frame.T, 0);
}

/** The axis of a frame that the joint's letter names; z of those without one. */
export function jointAxis(type: string): Vector3 {
  const letter = type[1];
  return new Vector3(letter === "x" ? 1 : 0, letter === "y" ? 1 : 0, letter === "x" || letter === "y" ? 0 : 1);
}

/** What belongs to each body: its ends of joints, and its frames. */
export interface Members { ends: { joint: number; end: 0 | 1; frame: number }[]; frames: number[] }

const found = new WeakMap<Model, Members[]>();

export function members(model: Model): Members[] {
  const known = found.get(model);
  if (known) return known;
  const out: Members[] = model.bodies.map(() => ({ ends: [], frames: [] }));
  model.frames.forEach((frame, f) => out[frame.body].frames.push(f));
  model.joints.forEach((joint, j) =>
    joint.frames.forEach((frame, end) => out[model.frames[frame].body].ends.push({ joint: j, end: end as 0 | 1, frame })),
  );
  found.set(model, out);
  return out;
}

/** Where joints and named frames are on a body, in its own frame; no two in one place. */
export function bodyPoints(model: Model, body: number, near: number): Vector3[] {
  const points: Vector3[] = [], { ends, frames } = members(model)[body], { mass, center } = model.bodies[body];
  const add = (at: Vector3): void => {
    if (!points.some((p) => p.distanceTo(at) <= near)) points.push(at);
  };
  for (const { frame } of ends) add(vector(model.frames[frame].T));
  if (body > 0) for (const f of frames.slice(1)) add(vector(model.frames[f].T));
  if (body > 0 && points.length === 1 && mass > 0) add(vector(center));
  return points;
}

/** How far apart the points of a body usually are: the median over the bodies; 0: none has two. */
export function usualReach(model: Model): number {
  const all: number[] = [];
  for (let b = 1; b < model.bodies.length; ++b) {
    const points = bodyPoints(model, b, 0), far = Math.max(0, ...points.map((p) => p.distanceTo(points[0])));
    if (far > 0) all.push(far);
  }
  return all.length ? all.sort((a, b) => a - b)[all.length >> 1] : 0;
}

/** The size of the mechanism: the diagonal of the box around its joints in a pose, and its middle. */
export function extent(model: Model, pose: Pose): { middle: Vector3; size: number } {
  const low = new Vector3(Infinity, Infinity, Infinity), high = new Vector3(-Infinity, -Infinity, -Infinity);
  const add = (body: number, at: Vector3): void => {
    const p = at.applyMatrix4(bodyMatrix(pose, body));
    low.min(p);
    high.max(p);
  };
  for (const joint of model.joints) for (const f of joint.frames) add(model.frames[f].body, vector(model.frames[f].T));
  model.bodies.forEach((body, b) => {
    if (b > 0) for (const p of bodyPoints(model, b, 0)) add(b, p);
    if (b > 0 && body.mass > 0 && body.patches) add(b, vector(body.center));
  });
  if (!(high.x >= low.x)) return { middle: new Vector3(), size: model.length };
  return { middle: low.clone().add(high).multiplyScalar(0.5), size: Math.max(high.distanceTo(low), 0.2 * model.length) };
}
