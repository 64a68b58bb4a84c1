// The links of bodies without meshes: bars, plates and hulls between the joints.
import { BufferGeometry, CapsuleGeometry, CylinderGeometry, Float32BufferAttribute, Quaternion, SphereGeometry, Vector3 } from "three";
import { ConvexGeometry } from "three/examples/jsm/geometries/ConvexGeometry.js";
import { mergeGeometries } from "three/examples/jsm/utils/BufferGeometryUtils.js";

const UP = new Vector3(0, 1, 0);

export function rod(from: Vector3, to: Vector3, radius: number, fine = true): BufferGeometry {
  const way = to.clone().sub(from), length = way.length();
  const long = Math.max(length, 1e-9), geometry = fine ? new CapsuleGeometry(radius, long, 6, 14) : new CylinderGeometry(radius, radius, long, 5);
  if (length > 0) geometry.applyQuaternion(new Quaternion().setFromUnitVectors(UP, way.divideScalar(length)));
  const middle = from.clone().add(to).multiplyScalar(0.5);
  return geometry.translate(middle.x, middle.y, middle.z);
}

/** The normal of points in one plane; null where they lie in a line or in space. */
export function planeOf(points: Vector3[], size: number): Vector3 | null {
  let best = new Vector3();
  for (let i = 1; i < points.length; ++i)
    for (let j = i + 1; j < points.length; ++j) {
      const normal = points[i].clone().sub(points[0]).cross(points[j].clone().sub(points[0]));
      if (normal.length() > best.length()) best = normal;
    }
  if (best.length() < 1e-6 * size * size) return null;
  best.normalize();
  const flat = points.every((p) => Math.abs(p.clone().sub(points[0]).dot(best)) < 1e-3 * size);
  return flat ? best : null;
}

function inLine(points: Vector3[], size: number): boolean {
  const first = points[0], far = points.reduce((a, p) => (p.distanceTo(first) > a.distanceTo(first) ? p : a), first);
  const way = far.clone().sub(first).normalize();
  return points.every((p) => p.clone().sub(first).cross(way).length() < 1e-3 * size);
}

/** The corners of the convex hull of points in a plane, in order. */
function hull(points: Vector3[], normal: Vector3): Vector3[] {
  const x = Math.abs(normal.x) < 0.9 ? new Vector3(1, 0, 0) : new Vector3(0, 1, 0);
  const u = x.sub(normal.clone().multiplyScalar(x.dot(normal))).normalize(), v = normal.clone().cross(u);
  const spots = points.map((p) => ({ p, x: p.dot(u), y: p.dot(v) })).sort((a, b) => a.x - b.x || a.y - b.y);
  const turn = (a: typeof spots[0], b: typeof spots[0], c: typeof spots[0]): number =>
    (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
  const half = (list: typeof spots): typeof spots => {
    const out: typeof spots = [];
    for (const s of list) {
      while (out.length > 1 && turn(out[out.length - 2], out[out.length - 1], s) <= 0) out.pop();
      out.push(s);
    }
    return out.slice(0, -1);
  };
  return [...half(spots), ...half([...spots].reverse())].map((s) => s.p);
}

/** A plate between corners, with rods for edges; `thin` is half its thickness. */
function plate(corners: Vector3[], normal: Vector3, thin: number): BufferGeometry {
  const top = corners.map((c) => c.clone().addScaledVector(normal, thin)), low = corners.map((c) => c.clone().addScaledVector(normal, -thin));
  const numbers: number[] = [], n = corners.length;
  const add = (...points: Vector3[]): void => points.forEach((p) => numbers.push(p.x, p.y, p.z));
  for (let i = 1; i + 1 < n; ++i) {
    add(top[0], top[i], top[i + 1]);
    add(low[0], low[i + 1], low[i]);
  }
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", new Float32BufferAttribute(numbers, 3));
  geometry.computeVertexNormals();
  return geometry;
}

/** What a merge needs: positions and normals only, no index. */
export function plain(geometry: BufferGeometry): BufferGeometry {
  const out = geometry.index ? geometry.toNonIndexed() : geometry;
  for (const name of Object.keys(out.attributes)) if (name !== "position" && name !== "normal") out.deleteAttribute(name);
  return out;
}

/** The shape of a link over its points, all of it within one geometry; `fine`: with many facets. */
export function linkGeometry(points: Vector3[], radius: number, size: number, fine: boolean): BufferGeometry | null {
  const parts: BufferGeometry[] = [];
  if (points.length === 1) parts.push(new SphereGeometry(1.5 * radius, 20, 14).translate(points[0].x, points[0].y, points[0].z));
  else if (points.length > 1 && inLine(points, size)) {
    const far = points.reduce((a, p) => (p.distanceTo(points[0]) > a.distanceTo(points[0]) ? p : a), points[0]);
    const other = points.reduce((a, p) => (p.distanceTo(far) > a.distanceTo(far) ? p : a), far);
    parts.push(rod(far, other, radius, fine));
  } else if (points.length > 2) {
    const normal = planeOf(points, size);
    if (normal) {
      const corners = hull(points, normal);
      parts.push(plate(corners, normal, 0.45 * radius));
      corners.forEach((c, i) => parts.push(rod(c, corners[(i + 1) % corners.length], 0.8 * radius, fine)));
    } else if (points.length > 24) parts.push(new ConvexGeometry(points));
    else {
      parts.push(new ConvexGeometry(points));
      for (const p of points) parts.push(new SphereGeometry(0.9 * radius, 12, 8).translate(p.x, p.y, p.z));
    }
  }
  return parts.length ? mergeGeometries(parts.map(plain)) : null;
}
