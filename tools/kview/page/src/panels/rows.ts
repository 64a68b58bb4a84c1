// Rows of a table as curves need them.
import { Table } from "../protocol";

/** The columns that answer the question: the others are the pose and its evidence. */
export function answers(table: Table): number[] {
  const begins = (pattern: RegExp): number[] => table.columns.flatMap((c, i) => (pattern.test(c.name) ? [i] : []));
  if (table.question === "mobility") return begins(/^m\./);
  if (table.question === "motion") return begins(/^v\./);
  if (table.question === "advantage") return begins(/^ma\./);
  if (table.question === "allowance") return begins(/^play\./);
  if (table.question === "clearance") return begins(/^clearance\./);
  if (table.question === "track") return begins(/^(limit_margin$|objective\.|z\.)/);
  const forces = begins(/^f\./);
  return forces.length ? forces : begins(/^fbar\./); // without actuators: the least forces that hold the pose
}

export function spread(values: Float64Array): number {
  let low = Infinity, high = -Infinity;
  for (const v of values) if (Number.isFinite(v)) (low = Math.min(low, v)), (high = Math.max(high, v));
  return high - low;
}

export function rowAt(s: Float64Array, x: number): number {
  let best = 0;
  for (let r = 1; r < s.length; ++r) if (Math.abs(s[r] - x) < Math.abs(s[best] - x)) best = r;
  return best;
}

/** Between rows by the line through both; null outside and where there is no value. */
export function between(s: ArrayLike<number>, values: ArrayLike<number | null>, x: number): number | null {
  for (let r = 1; r < s.length; ++r) {
    const low = Math.min(s[r - 1], s[r]), high = Math.max(s[r - 1], s[r]);
    if (x < low || x > high) continue;
    const a = values[r - 1], b = values[r];
    if (a === null || b === null || !Number.isFinite(a) || !Number.isFinite(b)) return null;
    return s[r] === s[r - 1] ? a : a + ((x - s[r - 1]) / (s[r] - s[r - 1])) * (b - a);
  }
  return null;
}

/** The range of an axis whose curves may have poles: what most rows need. */
export function tamed(low: number, high: number, lines: { table: Table; column: string }[]): [number, number] {
  const all: number[] = [];
  for (const line of lines) for (const v of line.table.values[line.table.columns.findIndex((c) => c.name === line.column)] ?? []) if (Number.isFinite(v)) all.push(v);
  if (!all.length) return [low ?? 0, high ?? 1];
  all.sort((a, b) => a - b);
  const at = (part: number): number => all[Math.round(part * (all.length - 1))], middle = at(0.95) - at(0.05);
  const bottom = Math.max(all[0], at(0.05) - 2 * middle), top = Math.min(all[all.length - 1], at(0.95) + 2 * middle), pad = 0.06 * (top - bottom) || 0.1 * Math.abs(top) || 1;
  return [bottom - pad, top + pad];
}

/** Labels in their order from top to bottom, moved so far that none covers another. */
export function apart<T extends { y: number }>(labels: T[], height: number, top: number, bottom: number): T[] {
  const sorted = labels.sort((a, b) => a.y - b.y);
  sorted.forEach((label, i) => (label.y = Math.max(label.y, top, i ? sorted[i - 1].y + height : top)));
  for (let i = sorted.length - 1, below = bottom; i >= 0; --i) below = (sorted[i].y = Math.min(sorted[i].y, below)) - height;
  return sorted;
}
