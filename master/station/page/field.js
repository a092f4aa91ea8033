// Draws the displacement of the model in colours over a camera image. A shared file contains
// `drawField` as text, so it uses only its arguments, `viridis` and the canvas.
import { viridis } from './colours.js';

// Returns the magnitude for each node of `displacement`, x, y, z per node.
export const magnitudesOf = (displacement) =>
  Float32Array.from({ length: displacement.length / 3 }, (_, i) => Math.hypot(...displacement.subarray(3 * i, 3 * i + 3)));

// Returns the triangles that face the camera; for a planar body all of them. `image`: u, v per node
// with v down; `triangles`: counter-clockwise seen from outside.
export function visibleOf(triangles, image, isPlanar) {
  if (isPlanar) return triangles;
  const area = (a, b, c) =>
    (image[2 * b] - image[2 * a]) * (image[2 * c + 1] - image[2 * a + 1]) -
    (image[2 * c] - image[2 * a]) * (image[2 * b + 1] - image[2 * a + 1]);
  const seen = [];
  for (let i = 0; i < triangles.length; i += 3)
    if (area(triangles[i], triangles[i + 1], triangles[i + 2]) < 0) seen.push(triangles[i], triangles[i + 1], triangles[i + 2]);
  return seen;
}

// Draws bands of equal displacement. `values`: per node, 1 at full colour; `triangles`: three node
// indices each; `at(node)`: its position on the canvas. The lowest band is not drawn, so that the
// image is visible where nothing moves.
export function drawField(pen, triangles, values, at) {
  const bands = 12, places = Array.from(values, (_, node) => at(node));
  for (let band = 1; band < bands; ++band) {
    const level = band / bands;
    pen.beginPath();
    for (let i = 0; i < triangles.length; i += 3) {
      let isBegun = false;
      const line = (x, y) => {
        pen[isBegun ? 'lineTo' : 'moveTo'](x, y);
        isBegun = true;
      };
      for (let k = 0; k < 3; ++k) {
        const a = triangles[i + k], b = triangles[i + ((k + 1) % 3)], [p, q] = [places[a], places[b]];
        const isAbove = values[a] >= level;
        if (isAbove) line(p[0], p[1]);
        if (isAbove === values[b] >= level) continue;
        const part = (level - values[a]) / (values[b] - values[a]);
        line(p[0] + part * (q[0] - p[0]), p[1] + part * (q[1] - p[1]));
      }
      if (isBegun) pen.closePath();
    }
    pen.fillStyle = `rgb(${viridis((band + 0.5) / bands).map(Math.round)})`;
    pen.fill();
  }
}
