// Elements in one call.

type Child = Node | string | null | undefined;
type Props = Record<string, unknown>;

/** An element with properties (`class`, `aria-…`, `on…` listeners, others as they are) and children. */
export function el<K extends keyof HTMLElementTagNameMap>(tag: K, props: Props = {}, ...children: Child[]): HTMLElementTagNameMap[K] {
  const node = document.createElement(tag);
  for (const [key, value] of Object.entries(props)) {
    if (value === undefined || value === null || value === false) continue;
    if (key.startsWith("on")) node.addEventListener(key.slice(2), value as EventListener);
    else if (key === "class") node.className = String(value);
    else if (key === "text") node.textContent = String(value);
    else node.setAttribute(key, value === true ? "" : String(value));
  }
  for (const child of children) if (child !== null && child !== undefined) node.append(child);
  return node;
}

/** A button with an accessible name; `text` may be a symbol. */
export function button(text: string, name: string, click: () => void, props: Props = {}): HTMLButtonElement {
  return el("button", { type: "button", "aria-label": name, title: name, onclick: click, ...props }, text);
}

export function replace(node: HTMLElement, ...children: Child[]): void {
  node.replaceChildren(...children.filter((c): c is Node | string => c !== null && c !== undefined));
}

/** A number for people: as many digits as its size needs. */
export function shown(value: number, digits = 4): string {
  if (!Number.isFinite(value)) return Number.isNaN(value) ? "–" : value > 0 ? "∞" : "−∞";
  if (value === 0) return "0";
  const size = Math.abs(value);
  if (size >= 1e6 || size < 1e-4) return value.toExponential(digits - 2).replace("-", "−");
  return value.toFixed(Math.max(0, Math.min(6, digits - 1 - Math.floor(Math.log10(size))))).replace("-", "−");
}

/** A number as people type it; NaN where it is none. */
export function typed(text: string): number {
  const plain = text.trim().replace("−", "-").replace(",", ".");
  return plain === "" ? NaN : Number(plain);
}

export function save(name: string, text: string, type: string): void {
  const link = el("a", { href: URL.createObjectURL(new Blob([text], { type })), download: name });
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 1000);
}
