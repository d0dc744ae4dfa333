// Solids in space as a canvas draws them: turning by quaternions, a camera, faces and outlines.

const CIRCLE = 24, GRID = 16;   // segments of a circle, cells of a grid

/** v turned by the unit quaternion [w, x, y, z]. */
export function turned([w, x, y, z], [a, b, c]) {
  const [s, t, u] = [y * c - z * b + w * a, z * a - x * c + w * b, x * b - y * a + w * c];
  return [a + 2 * (y * u - z * t), b + 2 * (z * s - x * u), c + 2 * (x * t - y * s)];
}

/** Between two unit quaternions, along the shorter way. */
export function between(from, to, part) {
  const sense = from.reduce((sum, value, k) => sum + value * to[k], 0) < 0 ? -1 : 1;
  const mixed = from.map((value, k) => value + part * (sense * to[k] - value));
  const length = Math.hypot(...mixed) || 1;
  return mixed.map((value) => value / length);
}

export const added = (a, b) => a.map((value, k) => value + b[k]);
const minus = (a, b) => a.map((value, k) => value - b[k]);
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];

/** An orthographic camera: `yaw` about the vertical, `pitch` from the horizontal, both in radians. */
export class Camera {
  yaw = 0.6;
  pitch = 0.35;
  scale = 400;   // pixels for a metre
  centre = [0, 0, 0];

  /** Right, up, and towards the eye. */
  axes() {
    const [c, s, p, q] = [Math.cos(this.yaw), Math.sin(this.yaw), Math.cos(this.pitch), Math.sin(this.pitch)];
    return [[c, s, 0], [-s * q, c * q, p], [s * p, -c * p, q]];
  }

  /** A function from points to pixels and depth, which grows towards the eye. */
  projection(width, height) {
    const [right, up, eye] = this.axes();
    return (point) => {
      const from = minus(point, this.centre);
      return [width / 2 + this.scale * dot(from, right), height / 2 - this.scale * dot(from, up), dot(from, eye)];
    };
  }

  /** So that all these points are seen. */
  fit(points, width, height) {
    if (!points.length || !width || !height) return;
    const low = points.reduce((a, b) => a.map((v, k) => Math.min(v, b[k])));
    const high = points.reduce((a, b) => a.map((v, k) => Math.max(v, b[k])));
    this.centre = low.map((value, k) => (value + high[k]) / 2);
    this.scale = 0.8 * Math.min(width, height) / Math.max(0.01, Math.hypot(...minus(high, low)));
  }
}

const CORNERS = [[-1, -1, -1], [1, -1, -1], [1, 1, -1], [-1, 1, -1], [-1, -1, 1], [1, -1, 1], [1, 1, 1], [-1, 1, 1]];
const FACES = [[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]];

/** Polygons in space, each with its normal; those of a ball are drawn by its outline. */
export function facesOf(shape, { position, turn, size }) {
  if (shape === "box") {
    const corners = CORNERS.map((corner) => added(position, turned(turn, corner.map((sign, k) => sign * size[k] / 2))));
    return FACES.map((face) => {
      const points = face.map((k) => corners[k]);
      return { points, normal: cross(minus(points[1], points[0]), minus(points[2], points[0])) };
    });
  }
  return [];
}

/** The centres of the two ends of a capsule. */
export const endsOf = ({ position, turn, size }) => [-1, 1].map((sign) => added(position, turned(turn, [0, 0, sign * size[1] / 2])));

/** Lines on a ball that show how it is turned: three great circles. */
export function circlesOf({ position, turn, size }) {
  return [0, 1, 2].map((axis) => Array.from({ length: CIRCLE + 1 }, (_, k) => {
    const angle = 2 * Math.PI * k / CIRCLE, flat = [Math.cos(angle), Math.sin(angle)];
    const point = [0, 0, 0];
    point[(axis + 1) % 3] = size[0] * flat[0];
    point[(axis + 2) % 3] = size[0] * flat[1];
    return added(position, turned(turn, point));
  }));
}

/** A grid of lines in a plane near `centre`, `reach` m to each side. */
export function gridOf(normal, offset, centre, reach) {
  const length = Math.hypot(...normal), n = normal.map((value) => value / length);
  const first = Math.abs(n[2]) > 0.9 ? [1, 0, 0] : [0, 0, 1];
  const u = cross(n, first), size = Math.hypot(...u), a = u.map((value) => value / size), b = cross(n, a);
  const foot = added(centre, n.map((value) => value * (offset - dot(n, centre))));
  const at = (x, y) => foot.map((value, k) => value + x * a[k] + y * b[k]);
  const lines = [];
  for (let k = -GRID / 2; k <= GRID / 2; ++k) {
    const x = 2 * reach * k / GRID;
    lines.push([at(x, -reach), at(x, reach)], [at(-reach, x), at(reach, x)]);
  }
  return lines;
}

/** How light a face is, from 0 to 1, by its direction to the eye. */
export const lightness = (normal, eye) => Math.max(0, dot(normal, eye)) / (Math.hypot(...normal) || 1);
