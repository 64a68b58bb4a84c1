// The grid on the ground, or behind a planar mechanism.
import { GridHelper, LineBasicMaterial, Vector3 } from "three";
import { Actors } from "./actors";
import { vector } from "./geometry";

/** Cells of a round length; `towards`: where the viewer is. */
export function makeGrid(actors: Actors, normal: number[] | undefined, towards: Vector3, dark: boolean): GridHelper {
  const { size, middle, thick } = actors, cell = 10 ** Math.floor(Math.log10(size / 3)), count = 2 * Math.ceil((1.2 * size) / cell);
  const grid = new GridHelper(count * cell, count, dark ? "#3c424c" : "#c9ced6", dark ? "#2a2f37" : "#e3e6eb");
  if (normal) {
    const n = vector(normal), side = towards.dot(n) < 0 ? 12 : -12;
    grid.quaternion.setFromUnitVectors(new Vector3(0, 1, 0), n);
    grid.position.copy(middle).addScaledVector(n, side * thick - middle.dot(n));
  } else {
    grid.rotateX(Math.PI / 2);
    grid.position.set(Math.round(middle.x / cell) * cell, Math.round(middle.y / cell) * cell, Math.min(0, middle.z));
  }
  (grid.material as LineBasicMaterial).depthWrite = false;
  grid.renderOrder = -1;
  return grid;
}
