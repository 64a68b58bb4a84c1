// Names beside the joints, as text over the picture.
import { Camera, Vector3 } from "three";
import { el } from "../dom";

interface Label { node: HTMLElement; at: Vector3; shown: boolean }

export class Labels {
  readonly node = el("div", { class: "labels", "aria-hidden": "true" });
  private labels: Label[] = [];

  set(names: string[]): void {
    this.node.replaceChildren();
    this.labels = names.map((name) => {
      const node = el("span", { text: name });
      this.node.append(node);
      return { node, at: new Vector3(), shown: true };
    });
  }

  /** Puts each where `place` says. */
  each(place: (index: number) => Vector3): void {
    this.labels.forEach((label, i) => label.at.copy(place(i)));
  }

  emphasise(index: number): void {
    this.labels.forEach((label, i) => label.node.classList.toggle("on", i === index));
  }

  /** Puts the names where the camera sees their places; of those that would overlap only the first one shows. */
  draw(camera: Camera, width: number, height: number): void {
    const taken: [number, number, number][] = [];
    for (const label of this.labels) {
      const spot = label.at.clone().project(camera);
      const x = Math.round((0.5 + 0.5 * spot.x) * width), y = Math.round((0.5 - 0.5 * spot.y) * height);
      const wide = 8 * (label.node.textContent?.length ?? 1) + 4;
      const free = label.node.classList.contains("on") || !taken.some(([a, b, w]) => x < a + w && a < x + wide && Math.abs(y - b) < 15);
      const shown = free && spot.z < 1 && x > -20 && y > -20 && x < width + 20 && y < height + 20;
      if (shown) taken.push([x, y, wide]);
      if (shown !== label.shown) label.node.style.display = shown ? "" : "none";
      label.shown = shown;
      if (shown) label.node.style.transform = `translate(${x + 9}px,${y - 20}px)`;
    }
  }
}
