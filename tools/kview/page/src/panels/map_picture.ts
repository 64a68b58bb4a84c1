// The picture of a map: a column by colours over two axes, drivers or the place of a point, with curves and the outline.
import { scaleColour } from "../palette";
import { Table } from "../protocol";

export const SIZE = 480; // pixels of the picture, which the page scales
const OUTLIERS = 0.02; // share of the values beyond either end of the colours
const LONGEST = 0.2; // part of the axes: a larger face is at a singular configuration, or not one
const INKS = ["#000", "#cc1a1a", "#666", "#666"]; // by the kind of a curve: of the drivers, of the point, limit, clearance
const DASH = [8, 6];

export interface MapData {
  drivers: [number, number]; low: number[]; high: number[]; steps: number; cells: Table; curves: Table;
  frame: number; boundary: Table | null; // of the point; -1, null: none
}

/** Both axes of the picture, and the column whose numbers are its parts: sheets, or over a point aspects. */
export interface Axes { x: Float64Array; y: Float64Array; names: [string, string]; low: [number, number]; high: [number, number]; part: 2 | 3; isPoint: boolean }

export function columnOf(table: Table, name: string): Float64Array | undefined {
  return table.values[table.columns.findIndex((c) => c.name === name)];
}

export function overDrivers(map: MapData): Axes {
  const names = [0, 1].map((d) => map.cells.columns[d].name) as [string, string];
  return { x: map.cells.values[0], y: map.cells.values[1], names, low: [map.low[0], map.low[1]], high: [map.high[0], map.high[1]], part: 2, isPoint: false };
}

function extent(values: Float64Array): [number, number] {
  return values.reduce(([a, b], v) => [Math.min(a, v), Math.max(b, v)], [Infinity, -Infinity] as [number, number]);
}

/** The chart of a sphere, or the two coordinates of the place that vary most; equal scales. */
export function overPoint(map: MapData): Axes {
  const named = (prefix: string): string[] => map.cells.columns.map((c) => c.name).filter((name) => name.startsWith(prefix));
  const places = named("point.").map((name) => ({ name, span: extent(columnOf(map.cells, name)!).reduce((a, b) => b - a) }));
  const flattest = places.reduce((a, b) => (b.span <= a.span ? b : a));
  const chart = named("chart.");
  const names = (chart.length ? chart : places.filter((p) => p !== flattest).map((p) => p.name)) as [string, string];
  const [x, y] = names.map((name) => columnOf(map.cells, name)!), [a, b] = [extent(x), extent(y)];
  const half = 0.52 * Math.max(a[1] - a[0], b[1] - b[0]), middle = [0.5 * (a[0] + a[1]), 0.5 * (b[0] + b[1])];
  return { x, y, names, low: [middle[0] - half, middle[1] - half], high: [middle[0] + half, middle[1] + half], part: 3, isPoint: true };
}

interface Pen { context: CanvasRenderingContext2D; x: (v: number) => number; y: (v: number) => number }

/** Faces between grid points of one part. */
function drawFaces(pen: Pen, map: MapData, axes: Axes, own: number[], colour: (r: number) => string | null): void {
  const { context } = pen, across = map.steps + 1, rows = new Int32Array(across * across).fill(-1);
  const at = (d: number, r: number): number => Math.round(((map.cells.values[d][r] - map.low[d]) / (map.high[d] - map.low[d])) * map.steps);
  for (const r of own) rows[at(1, r) * across + at(0, r)] = r;
  const most = Math.max(LONGEST, 3 / across) * SIZE;
  context.lineWidth = 0.7;
  for (let j = 0; j + 1 < across; ++j)
    for (let i = 0; i + 1 < across; ++i) {
      const k = j * across + i, corners = [rows[k], rows[k + 1], rows[k + across + 1], rows[k + across]].filter((r) => r >= 0);
      const fill = corners.length > 2 ? colour(corners[0]) : null;
      const points = corners.map((r) => [pen.x(axes.x[r]), pen.y(axes.y[r])]);
      if (!fill || points.some((p) => Math.hypot(p[0] - points[0][0], p[1] - points[0][1]) > most)) continue;
      context.fillStyle = context.strokeStyle = fill;
      context.beginPath();
      for (const [x, y] of points) context.lineTo(x, y);
      context.closePath();
      context.fill();
      context.stroke();
    }
}

/** Lines of a table whose rows have equal numbers in the first column, broken where a hinge passes a full turn. */
function drawLines(pen: Pen, table: Table, names: [string, string], wanted: (kind: number) => boolean, width: number): void {
  const { context } = pen, [group, kinds] = table.values, [u, v] = names.map((name) => columnOf(table, name)!);
  for (let kind = 0; kind < INKS.length; ++kind) {
    if (!wanted(kind)) continue;
    context.beginPath();
    for (let r = 1; r < group.length; ++r) {
      const a = [pen.x(u[r - 1]), pen.y(v[r - 1])], b = [pen.x(u[r]), pen.y(v[r])];
      if (kinds[r] !== kind || group[r] !== group[r - 1] || Math.abs(a[0] - b[0]) > SIZE / 4 || Math.abs(a[1] - b[1]) > SIZE / 4) continue;
      if (r < 2 || kinds[r - 1] !== kind || group[r - 1] !== group[r - 2]) context.moveTo(a[0], a[1]);
      context.lineTo(b[0], b[1]);
    }
    context.setLineDash([]);
    context.lineWidth = width + 3;
    context.strokeStyle = "rgba(255,255,255,.8)";
    context.stroke();
    context.setLineDash(kind === 1 ? DASH : []);
    context.lineWidth = width;
    context.strokeStyle = INKS[kind];
    context.stroke();
    context.setLineDash([]);
  }
}

/** Draws a part of the map with the present place; returns the values at both ends of the colours. */
export function drawMap(context: CanvasRenderingContext2D, map: MapData, axes: Axes, part: number, column: string, present: [number, number]): [number, number] {
  const values = columnOf(map.cells, column)!, parts = map.cells.values[axes.part];
  const own = Array.from(parts.keys()).filter((r) => parts[r] === part);
  const sorted = own.map((r) => values[r]).filter(Number.isFinite).sort((a, b) => a - b);
  const low = sorted[Math.floor(OUTLIERS * (sorted.length - 1))] ?? 0, high = sorted[Math.ceil((1 - OUTLIERS) * (sorted.length - 1))] ?? 1;
  const colour = (r: number): string | null => (Number.isFinite(values[r]) ? scaleColour(high > low ? (values[r] - low) / (high - low) : 1) : null);
  const pen: Pen = {
    context, x: (v) => ((v - axes.low[0]) / (axes.high[0] - axes.low[0])) * SIZE, y: (v) => SIZE - ((v - axes.low[1]) / (axes.high[1] - axes.low[1])) * SIZE,
  };
  context.clearRect(0, 0, SIZE, SIZE);
  context.lineJoin = "round";
  if (axes.isPoint) drawFaces(pen, map, axes, own, colour);
  else {
    const side = SIZE / map.steps + 0.7;
    for (const r of own) {
      const fill = colour(r);
      if (!fill) continue;
      context.fillStyle = fill;
      context.fillRect(pen.x(axes.x[r]) - 0.5 * side, pen.y(axes.y[r]) - 0.5 * side, side, side);
    }
  }
  drawLines(pen, map.curves, axes.names, (kind) => kind < 2 || !axes.isPoint, 2);
  if (axes.isPoint && map.boundary) drawLines(pen, map.boundary, axes.names, () => true, 4);
  context.lineWidth = 3;
  context.strokeStyle = "#fff";
  context.fillStyle = "#d55e00";
  context.beginPath();
  context.arc(pen.x(present[0]), pen.y(present[1]), 9, 0, 7);
  context.fill();
  context.stroke();
  return [low, high];
}
