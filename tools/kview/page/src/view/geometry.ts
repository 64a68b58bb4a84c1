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

/** Where joints and named frames are on a body, in its own frame; no two in one place. */
export function bodyPoints(model: Model, body: number, near: number): { at: Vector3; joint: number }[] {
  const points: { at: Vector3; joint: number }[] = [];
  const add = (at: Vector3, joint: number): void => {
    if (!points.some((p) => p.at.distanceTo(at) <= near)) points.push({ at, joint });
  };
  model.joints.forEach((joint, j) =>
    joint.frames.forEach((f) => {
      if (model.frames[f].body === body) add(vector(model.frames[f].T), j);
    }),
  );
  let first = true;
  for (const frame of model.frames) {
    if (frame.body !== body) continue;
    if (!first && body > 0) add(vector(frame.T), -1);
    first = false;
  }
  const mass = model.bodies[body].mass;
  if (body > 0 && points.length === 1 && mass > 0) add(vector(model.bodies[body].center), -1);
  return points;
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
    if (b > 0) for (const p of bodyPoints(model, b, 0)) add(b, p.at);
    if (b > 0 && body.mass > 0 && body.patches) add(b, vector(body.center));
  });
  if (!(high.x >= low.x)) return { middle: new Vector3(), size: model.length };
  return { middle: low.clone().add(high).multiplyScalar(0.5), size: Math.max(high.distanceTo(low), 0.2 * model.length) };
}
