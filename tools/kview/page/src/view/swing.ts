// An instantaneous motion, shown as a small swing about the pose.
import { Matrix4, Quaternion, Vector3 } from "three";
import { Pose } from "../protocol";
import { bodyMatrix, vector } from "./geometry";

const SWING = 0.12; // of the mechanism's size, or twice that in radians

/** The pose after a part (-1 to 1) of the swing, every body along its own twist. */
export function swung(pose: Pose, twists: number[][], part: number, size: number): Pose {
  const fastest = Math.max(...twists.map((t) => Math.hypot(t[0], t[1], t[2]) / size + 0.5 * Math.hypot(t[3], t[4], t[5])), 1e-12);
  const amount = (SWING * part) / fastest, bodies = pose.bodies.slice();
  twists.forEach((twist, b) => {
    const w = vector(twist, 3), angle = w.length() * amount, X = bodyMatrix(pose, b);
    const place = new Vector3().setFromMatrixPosition(X).addScaledVector(vector(twist), amount);
    const turn = new Quaternion().setFromAxisAngle(w.lengthSq() ? w.normalize() : new Vector3(0, 0, 1), angle);
    const e = new Matrix4().makeRotationFromQuaternion(turn).multiply(X.setPosition(0, 0, 0)).elements;
    bodies.set([e[0], e[4], e[8], e[1], e[5], e[9], e[2], e[6], e[10], place.x, place.y, place.z], 12 * b);
  });
  return { ...pose, bodies };
}
