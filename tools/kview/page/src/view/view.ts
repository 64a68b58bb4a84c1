// The picture: camera, light, what the pointer grips, arrows, names. It draws only when something has changed.
import { AmbientLight, Box3, DirectionalLight, GridHelper, Group, OrthographicCamera, Plane, Raycaster, Scene, Vector2, Vector3, WebGLRenderer, MOUSE, TOUCH } from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";
import { el } from "../dom";
import { OKABE, scaleColour, softened } from "../palette";
import { Patch } from "../protocol";
import { Store } from "../store";
import { Actors, Look } from "./actors";
import { arrow, turn } from "./arrows";
import { bodyMatrix, frameMatrix, jointAxis, vector } from "./geometry";
import { makeGrid } from "./grid";
import { Labels } from "./labels";
import { swung } from "./swing";

export type Side = "fit" | "plane" | "xy" | "xz" | "yz" | "iso";
const SIDES: Record<string, [Vector3, Vector3]> = {
  xy: [new Vector3(0, 0, 1), new Vector3(0, 1, 0)],
  xz: [new Vector3(0, -1, 0), new Vector3(0, 0, 1)],
  yz: [new Vector3(1, 0, 0), new Vector3(0, 0, 1)],
  iso: [new Vector3(1, -1.5, 0.9), new Vector3(0, 0, 1)],
};

interface Grip { body: number; joint: number; point: Vector3; at: Vector3; plane: Plane; pointer: number }

export class View {
  readonly node: HTMLElement;
  readonly canvas: HTMLCanvasElement;
  private renderer: WebGLRenderer;
  private scene = new Scene();
  private camera = new OrthographicCamera(-1, 1, 1, -1, -100, 100);
  private controls: OrbitControls;
  private actors = new Actors();
  private labels = new Labels();
  private marks = new Group(); // arrows, paths
  private grid: GridHelper | null = null;
  private light = new DirectionalLight(0xffffff, 2.1);
  private patches: Patch[] = [];
  private dirty = true;
  private grip: Grip | null = null;
  private half: [number, number] = [1, 1];
  private built = "";
  private swingStart = 0;
  frames = 0;

  constructor(private store: Store) {
    this.canvas = el("canvas", { tabindex: "0", "aria-label": "The mechanism. Arrow keys turn the view; with Shift they pull the selected body or joint; plus and minus zoom.", role: "application" });
    this.node = el("div", { class: "view" }, this.canvas, this.labels.node);
    this.renderer = new WebGLRenderer({ canvas: this.canvas, antialias: true, alpha: true });
    this.renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
    this.scene.add(new AmbientLight(0xffffff, 1.5), this.light, this.actors.root, this.marks);
    this.controls = new OrbitControls(this.camera, this.canvas);
    this.controls.mouseButtons = { LEFT: MOUSE.ROTATE, MIDDLE: MOUSE.PAN, RIGHT: MOUSE.PAN };
    this.controls.touches = { ONE: TOUCH.ROTATE, TWO: TOUCH.DOLLY_PAN };
    this.controls.addEventListener("change", () => this.draw());
    this.canvas.addEventListener("pointerdown", (e) => this.press(e), { capture: true });
    this.canvas.addEventListener("pointermove", (e) => this.drag(e));
    for (const end of ["pointerup", "pointercancel"]) this.canvas.addEventListener(end, () => this.release());
    new ResizeObserver(() => this.resize()).observe(this.node);
    store.on(["model"], () => this.rebuild());
    store.on(["pose"], () => this.follow());
    store.on(["selection", "look", "why"], () => this.repaint());
    const frame = (time: number): void => {
      if (store.motion >= 0) this.swing(time);
      if (this.dirty) this.render();
      requestAnimationFrame(frame);
    };
    requestAnimationFrame(frame);
  }

  addPatch(patch: Patch): void {
    this.patches.push(patch);
  }

  forgetPatches(): void {
    this.patches = [];
    this.built = "";
  }

  draw(): void {
    this.dirty = true;
  }

  private look(): Look {
    const { store } = this, dark = document.documentElement.dataset.theme === "dark";
    const soft = (colour: string, b: number): string => (b === 0 ? (dark ? "#5d636d" : "#9aa0a8") : softened(colour, dark ? 0.05 : 0.22));
    return {
      dark,
      bodyColour: (b) => {
        if (store.colourBy === "substructures") {
          const joint = store.model.joints.find((j) => store.model.frames[j.frames[1]].body === b);
          const s = joint && joint.count ? store.model.coordinates[joint.first].substructure : -1;
          return b === 0 || s < 0 ? (dark ? "#5d636d" : "#b4b9c0") : softened(OKABE[s % OKABE.length]);
        }
        if (store.colourBy === "mobility") return b === 0 ? (dark ? "#50555e" : "#a8adb5") : dark ? "#7c828c" : "#c3c7cd";
        return soft(store.bodyColour(b), b);
      },
      jointColour: (j) => {
        const joint = store.model.joints[j];
        if (store.colourBy !== "mobility") return joint.count && store.model.coordinates[joint.first].held ? "#d55e00" : dark ? "#e8eaee" : "#2b2f36";
        let number = 0;
        for (let k = 0; k < joint.count; ++k) number = Math.max(number, store.pose.m[joint.first + k]);
        return scaleColour(number);
      },
    };
  }

  /** Has the body another design than its file, so that its mesh no longer fits? Then it is drawn as a link. */
  private isChanged(body: number): boolean {
    const { model, first } = this.store;
    return body > 0 && model.edited && model.frames.some((f, i) => f.body === body && f.T.some((x, k) => Math.abs(x - first[3 * i + k]) > 1e-9 * model.length));
  }

  /** Do joints show through bodies? Of planar mechanisms, and while pivots are dragged. */
  private over(): boolean {
    return this.store.mode === "design" || !!this.store.model.normal;
  }

  private rebuild(): void {
    const { model, pose } = this.store;
    if (!pose || pose.q.length !== model.coordinates.length || pose.bodies.length !== 12 * model.bodies.length) return;
    const first = this.built !== model.name + model.bodies.length;
    const middle = this.actors.middle.clone(), size = this.actors.size;
    this.actors.build(model, pose, this.patches.filter((p) => !this.isChanged(p.body)));
    this.labels.set(model.joints.length <= 400 ? model.joints.map((j) => j.label) : []);
    if (first) {
      this.built = model.name + model.bodies.length;
      this.see("fit");
    } else {
      this.actors.middle = middle;
      this.actors.size = size;
    }
    this.follow();
    this.repaint();
  }

  private follow(): void {
    const { model, pose } = this.store;
    if (!this.actors.root.children.length || pose.bodies.length !== 12 * model.bodies.length) {
      this.rebuild();
      return;
    }
    this.actors.move(model, pose);
    this.labels.each((j) => this.actors.place(model, pose, model.joints[j].frames[1]));
    if (this.store.colourBy === "mobility") this.actors.paint(this.look(), this.store.selection, this.store.frames, this.over());
    this.showMarks();
    this.draw();
  }

  repaint(): void {
    if (!this.store.pose) return;
    this.labels.node.hidden = !this.store.labels;
    const selected = this.store.selection;
    this.labels.emphasise(selected?.kind === "joint" ? selected.index : -1);
    this.actors.paint(this.look(), selected, this.store.frames, this.over());
    this.showMarks();
    this.draw();
  }

  // Arrows

  private showMarks(): void {
    const { store, marks } = this, thick = 0.55 * this.actors.thick, size = this.actors.size;
    marks.clear();
    if (store.arrows && store.forces) {
      const { loads, reactions } = store.forces;
      const largest = Math.max(1e-300, ...loads.map((l) => vector(l.force).length()), ...reactions.map((r) => vector(r.force).length()));
      const grown = (force: number[]): Vector3 => {
        const way = vector(force), length = way.length();
        return length > 1e-9 * largest ? way.multiplyScalar((0.22 * size * Math.sqrt(length / largest)) / length) : way.set(0, 0, 0);
      };
      for (const load of loads) marks.add(arrow(vector(load.point), grown(load.force), 1.3 * thick, "#d55e00"));
      for (const reaction of reactions) marks.add(arrow(vector(reaction.point), grown(reaction.force), thick, "#0072b2"));
    }
    this.showColumn(thick);
    const redundancy = store.diagnosis?.redundancies[store.redundancy];
    if (redundancy) {
      const way = vector(redundancy.direction), at = redundancy.rotation ? this.actors.middle : vector(redundancy.point);
      marks.add(
        redundancy.rotation
          ? turn(at, way, 0.12 * size, thick, "#cc79a7")
          : arrow(at.clone().addScaledVector(way, -0.13 * size), way.multiplyScalar(0.26 * size), 1.2 * thick, "#cc79a7", true),
      );
    }
    this.draw();
  }

  /** A column of an arm: at each joint an arrow along its axis, as long as its rate; turning ones with two heads. */
  private showColumn(thick: number): void {
    const { store } = this, { model, pose, columns } = store, rates = columns?.columns[store.column];
    if (!columns || !rates) return;
    const largest = Math.max(...rates.map(Math.abs), 1e-12);
    columns.coordinates.forEach((c, k) => {
      const joint = model.joints[model.coordinates[c].joint], frame = model.frames[joint.frames[0]], slides = /^T/.test(joint.type);
      const axis = jointAxis(joint.type).transformDirection(frameMatrix(frame)).transformDirection(bodyMatrix(pose, frame.body));
      const way = axis.multiplyScalar((0.2 * this.actors.size * rates[k]) / largest);
      if (way.length() > 0.004 * this.actors.size) this.marks.add(arrow(this.actors.place(model, pose, joint.frames[1]), way, 1.1 * thick, store.column === 0 ? "#009e73" : "#cc79a7", !slides));
    });
  }

  /** An instantaneous motion, back and forth about the pose. */
  private swing(time: number): void {
    const { store, actors } = this, motion = store.motions?.motions[store.motion];
    if (!motion) return;
    this.swingStart ||= time;
    const moved = swung(store.pose, motion.twists, Math.sin((time - this.swingStart) / 380), actors.size);
    actors.move(store.model, moved);
    this.draw();
  }

  stopSwing(): void {
    this.swingStart = 0;
    this.follow();
  }

  // Camera

  see(side: Side): void {
    const { middle, size } = this.actors, { normal } = this.store.model;
    const planar = normal && (side === "plane" || side === "fit");
    const [from, up] = planar ? this.planeSide(vector(normal)) : SIDES[side] ?? (side === "fit" ? SIDES.iso : [this.camera.position.clone().sub(this.controls.target), this.camera.up.clone()]);
    this.camera.up.copy(up);
    this.controls.target.copy(middle);
    this.camera.position.copy(middle).addScaledVector(from.clone().normalize(), 3 * size);
    this.camera.near = -20 * size;
    this.camera.far = 40 * size;
    this.camera.zoom = 1;
    this.camera.updateMatrixWorld();
    this.fit();
    this.setGrid();
    this.resize();
    this.controls.update();
    this.draw();
  }

  /** What of the view the mechanism takes: half its width and height seen from the camera, which looks at their middle. */
  private fit(): void {
    const box = new Box3(), right = new Vector3(), up = new Vector3(), out = new Vector3(), towards = this.camera.position.clone().sub(this.controls.target);
    this.camera.lookAt(this.controls.target);
    this.camera.updateMatrix(); // lookAt alone turns it, and leaves the matrix as it was
    this.camera.matrix.extractBasis(right, up, out);
    this.actors.corners((p) => box.expandByPoint(new Vector3(p.dot(right), p.dot(up), p.dot(out))));
    if (box.isEmpty()) return;
    const middle = box.getCenter(new Vector3()), size = box.getSize(new Vector3());
    this.controls.target.set(0, 0, 0).addScaledVector(right, middle.x).addScaledVector(up, middle.y).addScaledVector(out, middle.z);
    this.camera.position.copy(this.controls.target).add(towards);
    this.half = [0.5 * size.x + 3 * this.actors.thick, 0.5 * size.y + 3 * this.actors.thick];
  }

  private planeSide(normal: Vector3): [Vector3, Vector3] {
    const up = Math.abs(normal.z) > 0.9 ? new Vector3(0, 1, 0) : new Vector3(0, 0, 1);
    // seen so that x runs to the right
    const right = up.clone().cross(normal);
    const towards = right.x < -1e-9 ? normal.clone().negate() : normal.clone();
    return [towards, up];
  }

  private setGrid(): void {
    if (this.grid) this.scene.remove(this.grid);
    const towards = this.camera.position.clone().sub(this.controls.target);
    this.grid = makeGrid(this.actors, this.store.model.normal, towards, document.documentElement.dataset.theme === "dark");
    this.scene.add(this.grid);
  }

  themed(): void {
    if (!this.store.pose) return;
    this.setGrid();
    this.repaint();
  }

  private resize(): void {
    const width = this.node.clientWidth || 1, height = this.node.clientHeight || 1;
    this.renderer.setSize(width, height, false);
    const wide = width / height;
    const half = 1.12 * Math.max(this.half[1], this.half[0] / wide);
    this.camera.left = -half * wide;
    this.camera.right = half * wide;
    this.camera.top = half;
    this.camera.bottom = -half;
    this.camera.updateProjectionMatrix();
    this.draw();
  }

  private render(): void {
    this.dirty = false;
    ++this.frames;
    this.light.position.copy(this.camera.position).add(this.camera.up).add(new Vector3(0.4, 0.2, 0.3).multiplyScalar(this.actors.size));
    this.light.target.position.copy(this.controls.target);
    this.light.target.updateMatrixWorld();
    this.renderer.render(this.scene, this.camera);
    if (this.store.labels) this.labels.draw(this.camera, this.node.clientWidth, this.node.clientHeight);
  }

  /** Turns the view, for keys. */
  orbit(right: number, up: number): void {
    const offset = this.camera.position.clone().sub(this.controls.target);
    offset.applyAxisAngle(this.camera.up, -right);
    const side = this.camera.up.clone().cross(offset).normalize();
    offset.applyAxisAngle(side, up);
    this.camera.position.copy(this.controls.target).add(offset);
    this.controls.update();
    this.draw();
  }

  zoom(factor: number): void {
    this.camera.zoom *= factor;
    this.camera.updateProjectionMatrix();
    this.draw();
  }

  // The hand

  private ray(e: { clientX: number; clientY: number }): Raycaster {
    const box = this.canvas.getBoundingClientRect(), caster = new Raycaster();
    caster.setFromCamera(new Vector2((2 * (e.clientX - box.left)) / box.width - 1, 1 - (2 * (e.clientY - box.top)) / box.height), this.camera);
    return caster;
  }

  private hit(e: PointerEvent): { kind: string; index: number; at: Vector3 } | null {
    const hits = this.ray(e).intersectObjects(this.actors.root.children, true);
    let found: { kind: string; index: number; at: Vector3 } | null = null;
    for (const hit of hits) {
      const owner = this.actors.owner(hit.object, hit.instanceId);
      if (!owner || hit.object.type === "LineSegments" || (owner.kind === "body" && owner.index === 0)) continue;
      if (!found) found = { ...owner, at: hit.point };
      // a joint's symbol is small: it wins over the link that hides it
      if (owner.kind === "joint" && (this.over() || hit.distance - hits[0].distance < 12 * this.actors.thick)) return { ...owner, at: hit.point };
    }
    return found;
  }

  private press(e: PointerEvent): void {
    if (e.button !== 0 || this.store.motion >= 0 || this.grip) return;
    const hit = this.hit(e);
    if (!hit) return;
    this.store.select({ kind: hit.kind as "body" | "joint", index: hit.index });
    if (this.store.link.recorded) return;
    const { model, pose } = this.store;
    const joint = hit.kind === "joint" ? hit.index : -1;
    const body = joint >= 0 ? this.movingEnd(joint) : hit.index;
    const at = joint >= 0 ? this.actors.place(model, pose, model.joints[joint].frames[1]) : hit.at;
    const normal = model.normal ? vector(model.normal) : this.camera.position.clone().sub(this.controls.target).normalize();
    const point = at.clone().applyMatrix4(bodyMatrix(pose, body).invert());
    this.grip = { body, joint, point, at, plane: new Plane().setFromNormalAndCoplanarPoint(normal, at), pointer: e.pointerId };
    this.controls.enabled = false;
    this.canvas.setPointerCapture(e.pointerId);
    this.canvas.classList.add("gripping");
  }

  /** Of a joint's two bodies the one that isn't the ground. */
  private movingEnd(joint: number): number {
    const { model } = this.store, [parent, child] = model.joints[joint].frames.map((f) => model.frames[f].body);
    return child || parent;
  }

  private drag(e: PointerEvent): void {
    const { grip, store } = this;
    if (!grip) {
      if (e.pointerType === "mouse" && !e.buttons) this.canvas.classList.toggle("over", !!this.hit(e));
      return;
    }
    const target = this.ray(e).ray.intersectPlane(grip.plane, new Vector3());
    if (!target) return;
    if (store.mode === "design" && grip.joint >= 0) this.movePivot(grip.joint, target);
    else this.pullPoint(grip.body, grip.point, target, grip.plane.normal, () => this.grip === grip);
  }

  pullPoint(body: number, point: Vector3, target: Vector3, normal: Vector3, going: () => boolean): void {
    const numbers = [...point.toArray(), ...target.toArray(), ...normal.toArray()].map((x) => +x.toPrecision(12));
    this.store.pull(`point ${body} ${numbers.join(" ")}`, going);
  }

  movePivot(joint: number, target: Vector3): void {
    const { link } = this.store;
    link.pull(`pivot ${joint} ${target.toArray().map((x) => +x.toPrecision(12)).join(" ")}`, (answer) => {
      if (!this.store.take(answer)) return;
      void this.store.ask("pose");
      if (this.store.table) void this.store.ask("again");
    });
  }

  private release(): void {
    if (!this.grip) return;
    this.grip = null;
    this.controls.enabled = true;
    this.canvas.classList.remove("gripping");
    void this.store.settle();
  }

  /** Moves what is selected by a step on the screen, for keys. */
  nudge(right: number, up: number): void {
    const { store } = this, { model, pose, selection } = store;
    if (!selection || store.link.recorded) return;
    const joint = selection.kind === "joint" ? selection.index : -1, body = joint >= 0 ? this.movingEnd(joint) : selection.index;
    const at = joint >= 0 ? this.actors.place(model, pose, model.joints[joint].frames[1]) : this.centre(body);
    const x = new Vector3().setFromMatrixColumn(this.camera.matrixWorld, 0), y = new Vector3().setFromMatrixColumn(this.camera.matrixWorld, 1);
    const target = at.clone().addScaledVector(x, 0.01 * this.actors.size * right).addScaledVector(y, 0.01 * this.actors.size * up);
    if (store.mode === "design" && joint >= 0) this.movePivot(joint, target);
    else this.pullPoint(body, at.clone().applyMatrix4(bodyMatrix(pose, body).invert()), target, new Vector3().setFromMatrixColumn(this.camera.matrixWorld, 2), () => false);
  }

  private centre(body: number): Vector3 {
    const { model, pose } = this.store, ends = model.joints.flatMap((j) => j.frames).filter((f) => model.frames[f].body === body);
    const sum = ends.reduce((s, f) => s.add(this.actors.place(model, pose, f)), new Vector3());
    return ends.length ? sum.divideScalar(ends.length) : sum.setFromMatrixPosition(bodyMatrix(pose, body));
  }
}
