// The design by hand: parameters typed, variants kept, the model saved.
import { button, el, save, shown, typed } from "../dom";
import { Parameter } from "../protocol";
import { Store } from "../store";

/** The design has changed: the pose and the curve follow, and undo comes back to before. */
async function follow(store: Store): Promise<void> {
  await store.ask("pose");
  if (store.table) await store.ask("again");
  await store.settle();
}

async function take(store: Store, places: number[], parameters: number[]): Promise<void> {
  if (parameters.length && (await store.ask(`parameters ${parameters.join(" ")}`)).kind === "error") return;
  if ((await store.ask(`design ${places.join(" ")}`)).kind === "error") return;
  await follow(store);
}

function parameterRow(store: Store, parameter: Parameter, index: number): HTMLElement {
  const { name, note, low, high, value, file } = parameter;
  const plain = (x: number): string => String(Number(x.toPrecision(6))).replace("-", "−");
  const range = low === null && high === null ? "" : `${low === null ? "−∞" : plain(low)} … ${high === null ? "∞" : plain(high)}`;
  const field = el("input", { type: "text", inputmode: "decimal", "aria-label": `Parameter ${name}`, value: plain(value), onchange: () => void change() });
  const change = async (): Promise<void> => {
    const number = typed(field.value), values = store.model.parameters.map((p) => p.value);
    if (!Number.isFinite(number)) {
      field.value = plain(value);
      store.say(`"${name}" needs a number.`, true);
      return;
    }
    values[index] = number;
    if ((await store.ask(`parameters ${values.join(" ")}`)).kind === "error") field.value = plain(value);
    else await follow(store);
  };
  return el("label", { class: "parameter", title: note || null }, el("span", { class: value === file ? "" : "changed", text: name }), field, el("small", { text: range }));
}

export function parameters(store: Store): HTMLElement | null {
  const list = store.model.parameters;
  if (!list.length) return null;
  return el("div", { class: "group" }, el("h2", { text: "Parameters" }), ...list.slice(0, 60).map((p, i) => parameterRow(store, p, i)));
}

function variantTable(store: Store): HTMLElement {
  const rows = store.variants.map((v) => {
    const column = v.table?.columns.findIndex((c) => /^(ma|m|f)\./.test(c.name)) ?? -1;
    const values = v.table && column >= 0 ? Array.from(v.table.values[column]).filter(Number.isFinite) : [];
    return el("tr", {}, el("th", { scope: "row" }, button(v.name, `Take variant ${v.name}`, () => void take(store, v.places, v.parameters), { class: "chip" })),
      el("td", { text: values.length ? shown(Math.min(...values)) : "–" }), el("td", { text: values.length ? shown(Math.max(...values)) : "–" }));
  });
  return el("table", {}, el("thead", {}, el("tr", {}, el("th", { text: "Variant" }), el("th", { text: "least" }), el("th", { text: "most" }))), el("tbody", {}, ...rows));
}

export function variants(store: Store): HTMLElement {
  const { model } = store;
  const keep = (): void => {
    const name = String.fromCharCode(65 + store.variants.length), now = store.model;
    store.variants = [...store.variants, { name, places: now.frames.flatMap((f) => f.T), parameters: now.parameters.map((p) => p.value), table: store.table }];
    store.tell("variants");
  };
  const write = async (): Promise<void> => {
    const answer = await store.ask("write");
    if (answer.kind === "file") {
      store.saved = true;
      save(model.name.replace(/(\.\w+)?$/, ".changed.json"), answer.text, "application/json");
    }
  };
  return el("div", { class: "group" }, el("h2", { text: "Design" }), el("div", { class: "chips" },
    button("Keep as a variant", "Keep this design and its curve as a variant", keep, { disabled: store.variants.length >= 8 }),
    model.edited ? button("Back to the file's", "Take the file's own design", () => void take(store, store.first, model.parameters.map((p) => p.file))) : null,
    button("Save as a file", "Save the model with this pose and design", () => void write())),
    store.variants.length ? variantTable(store) : null);
}
