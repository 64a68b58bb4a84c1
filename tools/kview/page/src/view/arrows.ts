// Arrows for forces, motions and redundant constraints.
import { Color, ConeGeometry, CylinderGeometry, Group, Mesh, MeshLambertMaterial, TorusGeometry, Vector3 } from "three";

const UP = new Vector3(0, 1, 0);

/** From a point along a vector, as long as it is; `double`: with a second head, as for a torque. */
export function arrow(from: Vector3, way: Vector3, thick: number, colour: string, double = false): Group {
  const group = new Group(), length = way.length(); // over everything: forces are inside bodies
  if (!(length > 0)) return group;
  const material = new MeshLambertMaterial({ color: new Color(colour), depthTest: false, transparent: true });
  const head = Math.min(5 * thick, 0.5 * length), shaft = Math.max(length - head, 1e-9);
  group.add(new Mesh(new CylinderGeometry(0.7 * thick, 0.7 * thick, shaft, 12).translate(0, 0.5 * shaft, 0), material));
  group.add(new Mesh(new ConeGeometry(2 * thick, head, 16).translate(0, shaft + 0.5 * head, 0), material));
  if (double) group.add(new Mesh(new ConeGeometry(2 * thick, head, 16).translate(0, shaft - 0.4 * head, 0), material));
  group.quaternion.setFromUnitVectors(UP, way.clone().divideScalar(length));
  group.position.copy(from);
  return group;
}

/** A ring about a direction with an arrow's head: a rotation that is constrained. */
export function turn(at: Vector3, axis: Vector3, radius: number, thick: number, colour: string): Group {
  const group = new Group(), material = new MeshLambertMaterial({ color: new Color(colour), depthTest: false, transparent: true });
  group.add(new Mesh(new TorusGeometry(radius, 0.7 * thick, 10, 48, 1.6 * Math.PI), material));
  group.add(new Mesh(new ConeGeometry(2 * thick, 5 * thick, 16).rotateZ(-0.15).translate(radius * Math.cos(1.6 * Math.PI), radius * Math.sin(1.6 * Math.PI), 0), material));
  group.quaternion.setFromUnitVectors(new Vector3(0, 0, 1), axis.clone().normalize());
  group.position.copy(at);
  return group;
}
