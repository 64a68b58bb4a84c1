// The page: what it consists of, and how it begins.
import { el } from "./dom";
import { listen } from "./keys";
import { openLink } from "./link";
import { Answer, PROTOCOL } from "./protocol";
import { Store } from "./store";
import { Curves } from "./panels/curves";
import { Details } from "./panels/details";
import { Toolbar } from "./panels/toolbar";
import { Tree } from "./panels/tree";
import { View } from "./view/view";

const root = document.documentElement;
root.dataset.theme = matchMedia("(prefers-color-scheme: dark)").matches ? "dark" : "light";

const link = openLink();
if (link.recorded) root.dataset.recorded = "";
const store = new Store(link);
const view = new View(store);
const bar = new Toolbar(store, view);
const tree = new Tree(store);
const curves = new Curves(store);
const details = new Details(store, () => view.stopSwing());
const status = el("div", { class: "status", role: "status", "aria-live": "polite" });
listen(store, view, bar, curves);

store.on(["message"], () => {
  status.textContent = store.message;
  status.classList.toggle("alert", store.alert);
});
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", (e) => {
  if (root.dataset.theme !== (e.matches ? "dark" : "light")) bar.theme();
});

const stage = el("main", {}, view.node, status);
document.getElementById("app")!.append(bar.node, tree.node, stage, curves.node, details.node);

async function loadPatches(): Promise<void> {
  view.forgetPatches();
  for (let b = 0; b < store.model.bodies.length; ++b)
    for (let part = 0; part < store.model.bodies[b].patches; ++part) {
      const answer = await link.ask(`patch ${b} ${part}`);
      if (answer.kind === "patch") view.addPatch(answer);
      else store.take(answer);
    }
}

/** A model is there, or has changed: its pose and its surfaces follow. */
async function begin(model: Answer): Promise<void> {
  if (model.kind !== "model") {
    store.take(model);
    return;
  }
  store.model = model;
  const pose = await link.ask("pose");
  if (pose.kind !== "pose") return;
  store.pose = pose;
  await loadPatches();
  store.take(model);
  store.take(pose);
  if (model.notes.length) store.say(model.notes[0]);
}

link.onNews((answer) => {
  if (answer.kind === "model") {
    const edited = store.model?.edited;
    store.diagnosis = store.motions = store.forces = null;
    store.motion = -1;
    void begin(answer).then(() => store.say(`The file has changed and was read again.${
      !edited ? "" : answer.edited ? " Your design was kept: \"Back to the file's\" drops it." : " Your design doesn't fit it any more; kview writes it to a file when it ends."}`, edited && !answer.edited));
  } else store.take(answer);
});
link.onClosed((why) => store.say(why ? `${why}.` : `The connection to kview is closed. Start kview again to go on.${
  store.model?.edited ? " A design that wasn't saved is in a file beside it, MODEL.unsaved.json." : ""}`, true));
void link.ask(`hello ${PROTOCOL}`).then(async (model) => {
  await begin(model);
  if (!link.recorded && model.kind === "model" && model.edited) store.say("The design of the page that was closed last was taken up again. \"Back to the file's\" drops it.");
});
window.addEventListener("beforeunload", (event) => {
  if (!link.recorded && store.model?.edited && !store.saved) event.preventDefault();
});

// For tests and measurements.
Object.assign(window, { kview: { store, view, link } });
