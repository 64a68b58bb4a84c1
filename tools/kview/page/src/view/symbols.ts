// Joints by their symbols: pins, sliders, balls, in the frame that the joint starts from.
import { BoxGeometry, BufferGeometry, CylinderGeometry, Quaternion, SphereGeometry, TorusGeometry, Vector3 } from "three";
import { mergeGeometries } from "three/examples/jsm/utils/BufferGeometryUtils.js";
import { jointAxis } from "./geometry";

const UP = new Vector3(0, 1, 0);

function along(geometry: BufferGeometry, axis: Vector3): BufferGeometry {
  return geometry.applyQuaternion(new Quaternion().setFromUnitVectors(UP, axis));
}

function cross(radius: number): BufferGeometry {
  const arm = (axis: Vector3): BufferGeometry => along(new CylinderGeometry(0.45 * radius, 0.45 * radius, 4.4 * radius, 12), axis);
  return mergeGeometries([arm(new Vector3(1, 0, 0)), arm(new Vector3(0, 1, 0))])!;
}

/** The symbol of a joint type, about the origin of its frame; `width` is the half length of a pin. */
export function symbolGeometry(type: string, radius: number, width: number, fine: boolean): BufferGeometry {
  const around = fine ? 24 : 6, axis = jointAxis(type);
  if (/^R[xyz]$/.test(type)) return along(new CylinderGeometry(1.55 * radius, 1.55 * radius, 2 * width, around), axis);
  if (/^T[xyz]$/.test(type)) return along(new BoxGeometry(3.4 * radius, 5 * radius, 3.4 * radius), axis);
  if (type === "spherical") return new SphereGeometry(2.1 * radius, around, fine ? 16 : 5);
  if (type === "float") return new TorusGeometry(2.6 * radius, 0.4 * radius, 8, 24);
  if (type === "universal") return cross(radius);
  if (type === "planar") return along(new BoxGeometry(6 * radius, 0.7 * radius, 6 * radius), axis);
  if (type === "rigid") return new BoxGeometry(2.4 * radius, 2.4 * radius, 2.4 * radius);
  const barrel = along(new CylinderGeometry(1.7 * radius, 1.7 * radius, 5 * radius, around), axis); // cylindrical, screw
  if (type !== "screw") return barrel;
  const thread = new TorusGeometry(1.8 * radius, 0.3 * radius, 8, 24).rotateX(Math.PI / 2);
  return mergeGeometries([barrel, along(thread, axis)])!;
}
