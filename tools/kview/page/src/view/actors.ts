// Everything of a model that is drawn: bodies, joints, ground. Geometry is made once for a design, poses only move it.
import { BufferAttribute, BufferGeometry, Color, CylinderGeometry, DoubleSide, EdgesGeometry, Group, LineBasicMaterial, LineSegments, Matrix4, Mesh, MeshLambertMaterial, Object3D, Quaternion, Vector3, ConeGeometry, AxesHelper } from "three";
import { Model, Patch, Pose } from "../protocol";
import { Crowd, Owner, Solid } from "./crowd";
import { bodyMatrix, bodyPoints, extent, frameMatrix, jointAxis, members, usualReach, vector } from "./geometry";
import { linkGeometry, plain } from "./links";
import { symbolGeometry } from "./symbols";

export interface Look { bodyColour(body: number): string; jointColour(joint: number): string; dark: boolean }

const UP = new Vector3(0, 1, 0);
const MANY = 300; // bodies: from here on their shapes have fewer facets

export class Actors {
  readonly root = new Group();
  size = 1;
  middle = new Vector3();
  thick = 0.01; // half the width of a link
  private bodies: Group[] = [];
  private links: Crowd | null = null;
  private pins: Crowd | null = null;
  private rods: { joint: number; barrel: Mesh; rod: Mesh; length: number }[] = [];
  private axes = new Group();
  private outline: LineSegments[] = [];

  build(model: Model, pose: Pose, patches: Patch[]): void {
    this.clear();
    this.bodies = [];
    this.rods = [];
    this.outline = [];
    this.axes = new Group();
    this.root.add(this.axes);
    const { middle, size } = extent(model, pose);
    this.middle = middle;
    this.size = size;
    const reach = usualReach(model);
    // links of a long chain stay links, and are seen
    this.thick = reach > 0 ? Math.max(Math.min(0.013 * size, 0.12 * reach), 0.0025 * size) : 0.013 * size;
    const layers = this.layers(model), links: Solid[] = [], pins: Solid[] = [], shapes = new Map<string, BufferGeometry>();
    const own = new Map<number, Patch[]>();
    for (const patch of patches) own.set(patch.body, [...(own.get(patch.body) ?? []), patch]);
    model.bodies.forEach((_, b) => this.addBody(model, pose, b, own.get(b) ?? [], layers[b], links, shapes));
    model.joints.forEach((_, j) => this.addJoint(model, pose, j, pins, shapes));
    this.links = this.crowd(links);
    this.pins = this.crowd(pins);
    this.move(model, pose);
  }

  private crowd(solids: Solid[]): Crowd {
    const crowd = new Crowd(solids, this.material());
    this.root.add(crowd.node);
    return crowd;
  }

  /** What the last design left on the graphics card goes. */
  private clear(): void {
    this.links?.dispose();
    this.pins?.dispose();
    this.root.traverse((node) => {
      if (!(node instanceof Mesh || node instanceof LineSegments)) return;
      node.geometry.dispose();
      (node.material as MeshLambertMaterial).dispose();
    });
    this.root.clear();
  }

  /** Links of a planar mechanism lie over each other, as real ones do: no two that a joint ties together in one layer. */
  private layers(model: Model): number[] {
    const out: number[] = [], own = members(model);
    for (let b = 0; b < model.bodies.length; ++b) {
      const taken = new Set(own[b].ends.map(({ joint, end }) => out[model.frames[model.joints[joint].frames[1 - end]].body] ?? -1));
      let layer = b === 0 ? 0 : 1;
      while (taken.has(layer)) ++layer;
      out.push(layer);
    }
    return out;
  }

  private addBody(model: Model, pose: Pose, body: number, patches: Patch[], layer: number, links: Solid[], shapes: Map<string, BufferGeometry>): void {
    const group = new Group();
    group.userData = { kind: "body", index: body };
    group.matrixAutoUpdate = false;
    this.bodies.push(group);
    for (const patch of patches) group.add(this.surface(patch));
    if (body === 0) this.addGround(model, group);
    if (body > 0 && !patches.length && !this.isStrutEnd(model, body)) {
      const geometry = this.link(model, pose, body, layer, shapes);
      if (geometry) links.push({ geometry, owner: { kind: "body", index: body } });
    }
    if (group.children.length) this.root.add(group);
  }

  /** Axes of all bodies, made when they are first shown. */
  private showAxes(shown: boolean): void {
    this.axes.visible = shown;
    for (const body of shown && !this.axes.children.length ? this.bodies : []) {
      const axes = new AxesHelper(0.09 * this.size);
      axes.matrixAutoUpdate = false;
      axes.matrix.copy(body.matrix);
      this.axes.add(axes);
    }
  }

  /** A body that lies on the axis of a slide is drawn as a cylinder or its rod. */
  private isStrutEnd(model: Model, body: number): boolean {
    const slides = members(model)[body].ends.filter(({ joint }) => /^T[xyz]$/.test(model.joints[joint].type));
    if (!slides.length) return false;
    const points = bodyPoints(model, body, 1e-4 * this.size);
    return points.length <= 2 && slides.some(({ joint, frame: f }) => {
      const frame = model.frames[f], axis = jointAxis(model.joints[joint].type).transformDirection(frameMatrix(frame));
      return points.every((p) => p.clone().sub(vector(frame.T)).cross(axis).length() < 1e-3 * this.size);
    });
  }

  private material(opacity = 1): MeshLambertMaterial {
    return new MeshLambertMaterial({ transparent: opacity < 1, opacity, side: DoubleSide });
  }

  /** The shape of a link, in its layer; bodies alike share one. */
  private link(model: Model, pose: Pose, body: number, layer: number, shapes: Map<string, BufferGeometry>): BufferGeometry | null {
    const points = bodyPoints(model, body, 1e-4 * this.size), shift = new Vector3();
    if (model.normal) shift.copy(vector(model.normal)).transformDirection(bodyMatrix(pose, body).invert()).multiplyScalar(1.9 * this.thick * (layer - 1));
    const key = [...points, shift].flatMap((p) => p.toArray().map((x) => Math.round(x / (1e-5 * this.size)))).join();
    const known = shapes.get(key);
    if (known) return known;
    const geometry = linkGeometry(points, this.thick, this.size, model.bodies.length < MANY);
    if (geometry) shapes.set(key, geometry.translate(shift.x, shift.y, shift.z));
    return geometry;
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

  private addJoint(model: Model, pose: Pose, j: number, pins: Solid[], shapes: Map<string, BufferGeometry>): void {
    const joint = model.joints[j], [parent, child] = joint.frames.map((f) => model.frames[f].body);
    const struts = /^T[xyz]$/.test(joint.type) && this.isStrutEnd(model, parent) && this.isStrutEnd(model, child);
    const hidden = joint.type === "rigid" && model.bodies[child].patches > 0;
    if (!struts && !hidden) {
      const width = (model.normal ? 3.2 : 1.7) * this.thick, fine = model.bodies.length < MANY;
      const geometry = shapes.get(joint.type) ?? plain(symbolGeometry(joint.type, this.thick, width, fine));
      shapes.set(joint.type, geometry);
      pins.push({ geometry, owner: { kind: "joint", index: j } });
    }
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
      this.axes.children[b]?.matrix.copy(group.matrix);
    });
    this.links?.solids.forEach(({ owner }, i) => this.links!.move(i, this.bodies[owner.index].matrix));
    const place = new Matrix4();
    this.pins?.solids.forEach(({ owner }, i) => {
      const joint = model.joints[owner.index], frame = model.frames[joint.frames[/^T|cylindrical|screw/.test(joint.type) ? 1 : 0]];
      this.pins!.move(i, bodyMatrix(pose, frame.body, place).multiply(frameMatrix(frame)));
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

  /** Points that the view has to show: vertices of bodies and joints. */
  corners(take: (at: Vector3) => void): void {
    const at = new Vector3(), most = Math.ceil(200000 / Math.max(100, this.bodies.length));
    for (const group of this.bodies)
      group.traverse((node) => {
        if (!(node instanceof Mesh)) return;
        const position = (node.geometry as BufferGeometry).getAttribute("position") as BufferAttribute;
        const stride = Math.max(1, Math.floor(position.count / most));
        for (let i = 0; i < position.count; i += stride) take(at.fromBufferAttribute(position, i).applyMatrix4(node.matrixWorld));
      });
    this.links?.corners(most, take);
    this.pins?.corners(most, take);
  }

  /** What owns the thing that a ray has met; null: nothing that can be taken. */
  owner(node: Object3D | null, instance?: number): Owner | null {
    if (instance !== undefined) return (node?.userData.owners as Owner[] | undefined)?.[instance] ?? null;
    for (let at = node; at; at = at.parent) if (at.userData.kind) return at.userData as Owner;
    return null;
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
    const is = (owner: Owner): boolean => selected?.kind === owner.kind && selected.index === owner.index;
    this.links?.solids.forEach(({ owner }, i) => this.links!.paint(i, new Color(look.bodyColour(owner.index)), is(owner)));
    this.pins?.solids.forEach(({ owner }, i) => this.pins!.paint(i, new Color(look.jointColour(owner.index)), is(owner)));
    this.pins?.lift(over);
    for (const strut of this.rods) {
      paint(strut.barrel, new Color(look.jointColour(strut.joint)), false);
      paint(strut.rod, new Color(look.dark ? "#c8ccd2" : "#9aa0a8"), false);
    }
    for (const lines of this.outline) (lines.material as LineBasicMaterial).color.copy(line);
    this.showAxes(frames);
  }
}
