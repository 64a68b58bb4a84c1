// Everything that the mouse does, by keys.
import { Store } from "./store";
import { Curves } from "./panels/curves";
import { Toolbar } from "./panels/toolbar";
import { View } from "./view/view";

export function listen(store: Store, view: View, bar: Toolbar, curves: Curves): void {
  document.addEventListener("keydown", (e) => {
    const target = e.target as HTMLElement, typing = /^(INPUT|SELECT|TEXTAREA)$/.test(target.tagName);
    if ((e.ctrlKey || e.metaKey) && e.key.toLowerCase() === "z") {
      e.preventDefault();
      void bar.step(e.shiftKey ? 1 : -1);
      return;
    }
    if (typing || e.ctrlKey || e.metaKey || e.altKey) return;
    const arrows: Record<string, [number, number]> = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };
    if (target === view.canvas && e.key in arrows) {
      e.preventDefault();
      const [right, up] = arrows[e.key];
      if (e.shiftKey) view.nudge(right, up);
      else view.orbit(0.08 * right, 0.08 * up);
      return;
    }
    const actions: Record<string, () => void> = {
      f: () => view.see("fit"), "1": () => view.see("xy"), "2": () => view.see("xz"), "3": () => view.see("yz"), "4": () => view.see("iso"),
      "+": () => view.zoom(1.15), "-": () => view.zoom(1 / 1.15), d: () => bar.toggleDesign(), p: () => curves.startStop(),
      n: () => {
        store.labels = !store.labels;
        store.tell("look");
      },
      Escape: () => store.select(null),
    };
    const action = actions[e.key];
    if (!action) return;
    e.preventDefault();
    action();
  });
  document.addEventListener("keyup", (e) => {
    if (e.shiftKey || !e.key.startsWith("Arrow") || e.target !== view.canvas) return;
    void store.settle();
  });
}
