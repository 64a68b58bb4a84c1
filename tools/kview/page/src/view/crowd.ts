// Many solids of few shapes, each shape in one drawing call: links, or joints. Each has a place, a colour and an owner.
import { BufferGeometry, Color, Group, InstancedMesh, Matrix4, MeshLambertMaterial, Vector3 } from "three";

export interface Owner { kind: "body" | "joint"; index: number }
export interface Solid { geometry: BufferGeometry; owner: Owner }

const LIT = new Color("#ffffff");

export class Crowd {
  readonly node = new Group();
  private spots: { mesh: InstancedMesh; at: number }[] = []; // of each solid
  private meshes: InstancedMesh[] = [];

  constructor(readonly solids: Solid[], readonly material: MeshLambertMaterial) {
    const shapes = new Map<BufferGeometry, Owner[]>();
    for (const { geometry, owner } of solids) {
      if (!shapes.has(geometry)) shapes.set(geometry, []);
      shapes.get(geometry)!.push(owner);
    }
    const meshes = new Map<BufferGeometry, { mesh: InstancedMesh; next: number }>();
    for (const [geometry, owners] of shapes) {
      const mesh = new InstancedMesh(geometry, material, owners.length);
      mesh.frustumCulled = false;
      mesh.userData.owners = owners;
      meshes.set(geometry, { mesh, next: 0 });
      this.meshes.push(mesh);
    }
    this.spots = solids.map(({ geometry }) => {
      const shape = meshes.get(geometry)!;
      return { mesh: shape.mesh, at: shape.next++ };
    });
    if (this.meshes.length) this.node.add(...this.meshes);
  }

  move(index: number, place: Matrix4): void {
    const { mesh, at } = this.spots[index];
    mesh.setMatrixAt(at, place);
    mesh.instanceMatrix.needsUpdate = true;
    mesh.boundingSphere = null; // found anew by the next ray
  }

  /** `on`: lighter, as what is selected. */
  paint(index: number, colour: Color, on: boolean): void {
    const { mesh, at } = this.spots[index];
    mesh.setColorAt(at, on ? colour.clone().lerp(LIT, 0.35) : colour);
    mesh.instanceColor!.needsUpdate = true;
  }

  /** Whether they show through what is before them. */
  lift(over: boolean): void {
    this.material.depthTest = !over;
    for (const mesh of this.meshes) mesh.renderOrder = over ? 2 : 0;
  }

  /** Vertices in the inertial frame, at most so many of each solid. */
  corners(most: number, take: (at: Vector3) => void): void {
    const place = new Matrix4(), at = new Vector3();
    for (const spot of this.spots) {
      const position = spot.mesh.geometry.getAttribute("position"), stride = Math.max(1, Math.floor(position.count / most));
      spot.mesh.getMatrixAt(spot.at, place);
      for (let k = 0; k < position.count; k += stride) take(at.fromBufferAttribute(position, k).applyMatrix4(place));
    }
  }

  dispose(): void {
    for (const mesh of this.meshes) {
      mesh.geometry.dispose();
      mesh.dispose();
    }
    this.material.dispose();
  }
}
