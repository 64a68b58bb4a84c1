// Colours that colour-blind eyes tell apart (Okabe and Ito), and the scale of mobility numbers.

export const OKABE = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#b5a900"];
export const DASHES: number[][] = [[], [8, 4], [2, 3], [10, 3, 2, 3], [5, 2], [12, 4, 4, 4], [3, 6]];
export const GROUND = "#8a8f98";

// Dark blue to yellow (cividis, J. Nuñez and others, 2018): light rises evenly, for every kind of colour vision.
const SCALE = [[0, 34, 78], [50, 70, 110], [95, 104, 113], [124, 123, 120], [165, 156, 116], [212, 193, 92], [255, 234, 70]];

export function scaleColour(number: number): string {
  const at = Math.max(0, Math.min(1, number)) * (SCALE.length - 1), low = Math.min(SCALE.length - 2, Math.floor(at));
  const mixed = SCALE[low].map((c, k) => Math.round(c + (at - low) * (SCALE[low + 1][k] - c)));
  return `rgb(${mixed.join(",")})`;
}

/** In turn, but never that of a body next to it. */
export function bodyColours(bodies: number, pairs: [number, number][]): string[] {
  const out: number[] = [-1];
  for (let body = 1, next = 0; body < bodies; ++body) {
    const taken = new Set(pairs.filter((p) => p.includes(body)).map((p) => out[p[0] === body ? p[1] : p[0]]));
    let choice = next;
    for (let k = 0; k < OKABE.length && taken.has(choice); ++k) choice = (choice + 1) % OKABE.length;
    out.push(choice);
    next = (choice + 1) % OKABE.length;
  }
  return out.map((c) => (c < 0 ? GROUND : OKABE[c]));
}

/** A body's colour in the picture: lighter than a line's, so that edges and names stand out. */
export function softened(colour: string, part = 0.22): string {
  const value = parseInt(colour.slice(1), 16);
  const mixed = [16, 8, 0].map((shift) => Math.round(((value >> shift) & 255) * (1 - part) + 255 * part));
  return `#${mixed.map((c) => c.toString(16).padStart(2, "0")).join("")}`;
}
