// Everything of a model that is drawn: bodies, joints, ground. Geometry is made once for a design, poses only move it.
import { BufferAttribute, BufferGeometry, Color, CylinderGeometry, DoubleSide, EdgesGeometry, Group, LineBasicMaterial, LineSegments, Matrix4, Mesh, MeshLambertMaterial, Object3D, Quaternion, Vector3, ConeGeometry, AxesHelper } from "three";
import { Model, Patch, Pose } from "../protocol";
import { bodyMatrix, bodyPoints, extent, frameMatrix, jointAxis, vector } from "./geometry";
import { linkGeometry } from "./links";
import { symbolGeometry } from "./symbols";

export interface Look { bodyColour(body: number): string; jointColour(joint: number): string; dark: boolean }

const UP = new Vector3(0, 1, 0);

export class Actors {
  readonly root = new Group();
  size = 1;
  middle = new Vector3();
  thick = 0.01; // half the width of a link
  private bodies: Group[] = [];
  private joints: Mesh[] = [];
  private rods: { joint: number; barrel: Mesh; rod: Mesh; length: number }[] = [];
  private axes = new Group();
  private outline: LineSegments[] = [];

  build(model: Model, pose: Pose, patches: Patch[]): void {
    this.root.clear();
    this.bodies = [];
    this.joints = [];
    this.rods = [];
    this.outline = [];
    this.axes = new Group();
    this.root.add(this.axes);
    const { middle, size } = extent(model, pose);
    this.middle = middle;
    this.size = size;
    this.thick = 0.013 * size;
    const layers = this.layers(model);
    model.bodies.forEach((_, b) => this.addBody(model, pose, b, patches.filter((p) => p.body === b), layers[b]));
    model.joints.forEach((_, j) => this.addJoint(model, pose, j));
    this.move(model, pose);
  }

  /** Links of a planar mechanism lie over each other, as real ones do: no two that a joint ties together in one layer. */
  private layers(model: Model): number[] {
    const out: number[] = [];
    for (let b = 0; b < model.bodies.length; ++b) {
      const taken = new Set<number>();
      for (const joint of model.joints) {
        const ends = joint.frames.map((f) => model.frames[f].body);
        if (ends.includes(b)) taken.add(out[ends[0] === b ? ends[1] : ends[0]] ?? -1);
      }
      let layer = b === 0 ? 0 : 1;
      while (taken.has(layer)) ++layer;
      out.push(layer);
    }
    return out;
  }

  private addBody(model: Model, pose: Pose, body: number, patches: Patch[], layer: number): void {
    const group = new Group();
    group.userData = { kind: "body", index: body };
    group.matrixAutoUpdate = false;
    this.bodies.push(group);
    this.root.add(group);
    for (const patch of patches) group.add(this.surface(patch));
    if (body === 0) this.addGround(model, group);
    if (body > 0 && !patches.length) {
      const points = bodyPoints(model, body, 1e-4 * this.size).map((p) => p.at), bare = this.isStrutEnd(model, body);
      const geometry = bare ? null : linkGeometry(points, this.thick, this.size);
      if (geometry) group.add(this.link(model, pose, geometry, body, layer));
    }
    const axes = new AxesHelper(0.09 * this.size);
    axes.matrixAutoUpdate = false;
    this.axes.add(axes);
  }

  /** A body that lies on the axis of a slide is drawn as a cylinder or its rod. */
  private isStrutEnd(model: Model, body: number): boolean {
    return model.joints.some((joint) => {
      if (!/^T[xyz]$/.test(joint.type)) return false;
      const end = joint.frames.findIndex((f) => model.frames[f].body === body);
      if (end < 0) return false;
      const frame = model.frames[joint.frames[end]], axis = jointAxis(joint.type).transformDirection(frameMatrix(frame));
      const points = bodyPoints(model, body, 1e-4 * this.size);
      return points.length <= 2 && points.every((p) => p.at.clone().sub(vector(frame.T)).cross(axis).length() < 1e-3 * this.size);
    });
  }

  private material(opacity = 1): MeshLambertMaterial {
    return new MeshLambertMaterial({ transparent: opacity < 1, opacity, side: DoubleSide });
  }

  private link(model: Model, pose: Pose, geometry: BufferGeometry, body: number, layer: number): Mesh {
    const mesh = new Mesh(geometry, this.material());
    if (model.normal) {
      const toBody = bodyMatrix(pose, body).invert(), shift = vector(model.normal).transformDirection(toBody);
      mesh.position.copy(shift.multiplyScalar(1.9 * this.thick * (layer - 1)));
    }
    return mesh;
  }

  private surface(patch: Patch): Mesh {
    const geometry = new BufferGeometry();
    geometry.setAttribute("position", new BufferAttribute(patch.vertices, 3));
    geometry.setIndex(new BufferAttribute(patch.triangles, 1));
    const flat = geometry.toNonIndexed();
    flat.computeVertexNormals();
    const mesh = new Mesh(flat, this.material(patch.color[3] >= 0 ? patch.color[3] : 1));
    if (patch.color[3] >= 0) mesh.userData.colour = new Color(patch.color[0], patch.color[1], patch.color[2]);
    const lines = new LineSegments(new EdgesGeometry(geometry, 28), new LineBasicMaterial({ transparent: true, opacity: 0.35 }));
    this.outline.push(lines);
    mesh.add(lines);
    return mesh;
  }

  private addGround(model: Model, group: Group): void {
    model.joints.forEach((joint) => {
      const end = joint.frames.findIndex((f) => model.frames[f].body === 0);
      if (end < 0 || model.bodies.length > 200) return;
      const frame = model.frames[joint.frames[end]], axis = jointAxis(joint.type).transformDirection(frameMatrix(frame));
      const down = model.normal && Math.abs(model.normal[2]) > 0.9 ? new Vector3(0, -1, 0) : new Vector3(0, 0, -1);
      if (/^T/.test(joint.type)) {
        const rail = new Mesh(new CylinderGeometry(0.5 * this.thick, 0.5 * this.thick, 0.5 * this.size, 8), this.material());
        rail.quaternion.setFromUnitVectors(UP, axis);
        rail.position.copy(vector(frame.T));
        group.add(rail);
        return;
      }
      const foot = new Mesh(new ConeGeometry(3.4 * this.thick, 5 * this.thick, 4, 1).rotateY(Math.PI / 4), this.material());
      foot.quaternion.setFromUnitVectors(UP, down.clone().negate());
      foot.position.copy(vector(frame.T).addScaledVector(down, 2.5 * this.thick));
      group.add(foot);
    });
  }

  private addJoint(model: Model, pose: Pose, j: number): void {
    const joint = model.joints[j], [parent, child] = joint.frames.map((f) => model.frames[f].body);
    const struts = /^T[xyz]$/.test(joint.type) && this.isStrutEnd(model, parent) && this.isStrutEnd(model, child);
    const hidden = joint.type === "rigid" && model.bodies[child].patches > 0;
    const mesh = new Mesh(struts || hidden ? new BufferGeometry() : symbolGeometry(joint.type, this.thick, (model.normal ? 3.2 : 1.7) * this.thick), this.material());
    mesh.matrixAutoUpdate = false;
    mesh.userData = { kind: "joint", index: j };
    this.joints.push(mesh);
    this.root.add(mesh);
    if (!struts) return;
    const patches = model.bodies[parent].patches && model.bodies[child].patches;
    const length = 0.62 * Math.max(Math.abs(pose.q[joint.first]), 0.02 * this.size), barrel = new Mesh(new CylinderGeometry(1.5 * this.thick, 1.5 * this.thick, 1, 20).translate(0, 0.5, 0), this.material());
    const rod = new Mesh(new CylinderGeometry(0.7 * this.thick, 0.7 * this.thick, 1, 16).translate(0, 0.5, 0), this.material());
    barrel.visible = rod.visible = !patches;
    barrel.userData = { kind: "joint", index: j };
    rod.userData = { kind: "body", index: child };
    this.rods.push({ joint: j, barrel, rod, length });
    this.root.add(barrel, rod);
  }

  /** Puts everything where a pose has it. */
  move(model: Model, pose: Pose): void {
    this.bodies.forEach((group, b) => {
      bodyMatrix(pose, b, group.matrix);
      this.axes.children[b].matrix.copy(group.matrix);
    });
    const place = new Matrix4();
    this.joints.forEach((mesh, j) => {
      const frame = model.frames[model.joints[j].frames[/^T|cylindrical|screw/.test(model.joints[j].type) ? 1 : 0]];
      mesh.matrix.copy(bodyMatrix(pose, frame.body, place).multiply(frameMatrix(frame)));
    });
    for (const strut of this.rods) this.moveStrut(model, pose, strut);
    this.root.updateMatrixWorld(true);
  }

  private moveStrut(model: Model, pose: Pose, strut: Actors["rods"][number]): void {
    const [from, to] = model.joints[strut.joint].frames.map((f) => this.place(model, pose, f));
    const way = to.clone().sub(from), length = way.length() || 1e-9, direction = way.divideScalar(length);
    const turn = new Quaternion().setFromUnitVectors(UP, direction);
    strut.barrel.position.copy(from);
    strut.barrel.quaternion.copy(turn);
    strut.barrel.scale.set(1, Math.min(strut.length, length), 1);
    strut.rod.position.copy(from);
    strut.rod.quaternion.copy(turn);
    strut.rod.scale.set(1, length, 1);
  }

  /** Points that the view has to show: all vertices of bodies and joints, or the corners of their boxes. */
  corners(take: (at: Vector3) => void): void {
    const at = new Vector3();
    for (const group of [...this.bodies, ...this.joints])
      group.traverse((node) => {
        if (!(node instanceof Mesh)) return;
        const position = (node.geometry as BufferGeometry).getAttribute("position");
        const stride = position ? Math.max(1, Math.floor(position.count / 2000)) : 1;
        for (let i = 0; position && i < position.count; i += stride) take(at.fromBufferAttribute(position as BufferAttribute, i).applyMatrix4(node.matrixWorld));
      });
  }

  /** A frame's origin in the inertial frame. */
  place(model: Model, pose: Pose, frame: number): Vector3 {
    return vector(model.frames[frame].T).applyMatrix4(bodyMatrix(pose, model.frames[frame].body));
  }

  /** Colours; `over`: joints show through the bodies, where they are looked for. */
  paint(look: Look, selected: { kind: string; index: number } | null, frames: boolean, over: boolean): void {
    const line = new Color(look.dark ? "#000" : "#222");
    const paint = (node: Object3D, colour: Color, on: boolean): void => {
      if (!(node instanceof Mesh)) return;
      const material = node.material as MeshLambertMaterial;
      material.color.copy((node.userData.colour as Color | undefined) ?? colour);
      material.emissive.set(on ? "#3a3a3a" : "#000");
    };
    this.bodies.forEach((group, b) => {
      const on = selected?.kind === "body" && selected.index === b;
      group.children.forEach((child) => paint(child, new Color(look.bodyColour(b)), on));
    });
    for (const mesh of this.joints) {
      (mesh.material as MeshLambertMaterial).depthTest = !over;
      mesh.renderOrder = over ? 2 : 0;
    }
    this.joints.forEach((mesh, j) => paint(mesh, new Color(look.jointColour(j)), selected?.kind === "joint" && selected.index === j));
    for (const strut of this.rods) {
      paint(strut.barrel, new Color(look.jointColour(strut.joint)), false);
      paint(strut.rod, new Color(look.dark ? "#c8ccd2" : "#9aa0a8"), false);
    }
    for (const lines of this.outline) (lines.material as LineBasicMaterial).color.copy(line);
    this.axes.visible = frames;
  }
}
