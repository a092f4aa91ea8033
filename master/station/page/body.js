// The object: at rest in grey lines, deformed in the colours of its displacement or of the traction on it.
import { viridisLight } from './colours.js';

const SINGLE_PRECISION = 1e-7;  // relative to the object's size: precision of received positions
const EDGE_ANGLE = 30;  // sharper edges are drawn [degrees]
const MIN_TRACTION = 1;  // at full colour [Pa]
const HELD_PX = 3, HELD = 0xf2f6fa;  // fixed nodes: lighter than the lower half of the colour bar
const UNKNOWN = [0.2, 0.2, 0.2];  // a colour that the colour bar does not contain

export class Body {
  // `quantity`: coloured by 'moved' (displacement) or 'traction', which may be unknown.
  constructor(three, message, colourScale, quantity = 'moved') {
    this.three = three;
    const { view, buffer } = message;
    [this.perElement, this.nodes, this.elements] = [16, 20, 24].map((at) => view.getUint32(at, true));
    this.rest = new Float32Array(buffer.slice(28, 28 + 12 * this.nodes));
    this.index = new Uint32Array(buffer.slice(28 + 12 * this.nodes, 28 + 12 * this.nodes + 4 * this.perElement * this.elements));
    this.held = new Uint32Array(buffer.slice(28 + 12 * this.nodes + 4 * this.perElement * this.elements));
    this.number = message.number;
    this.planar = this.perElement === 2;
    this.group = new three.Group();
    this.quantity = quantity;
    this.colourScale = colourScale;
    this.largest = { moved: 0, traction: null };
    this.box = new three.Box3().setFromArray(this.rest);
    if (this.planar) this.makePlanar();
    else this.makeSolid();
    if (this.held.length) this.makeHeld();
    this.deform(this.rest);
  }
  // Makes dots on the fixed nodes of the scene.
  makeHeld() {
    const { three } = this, places = new three.BufferGeometry();
    places.setAttribute('position', new three.BufferAttribute(this.rest, 3));
    places.setIndex(new three.BufferAttribute(this.held, 1));
    const supports = new three.Points(places, new three.PointsMaterial({ color: HELD, size: HELD_PX, sizeAttenuation: false }));
    if (this.planar) supports.position.z = this.ribbon * 0.6;
    this.group.add(supports);
  }
  dispose() {
    this.group.traverse((part) => {
      part.geometry?.dispose();
      part.material?.dispose();
    });
  }
  makeSolid() {
    const { three } = this;
    const atRest = new three.BufferGeometry();
    atRest.setAttribute('position', new three.BufferAttribute(this.rest, 3));
    atRest.setIndex(new three.BufferAttribute(this.index, 1));
    this.outline = new three.LineSegments(
      new three.EdgesGeometry(atRest, EDGE_ANGLE),
      new three.LineBasicMaterial({ transparent: true, opacity: 0.9 }),
    );
    this.geometry = new three.BufferGeometry();
    this.geometry.setIndex(new three.BufferAttribute(this.index, 1));
    this.positions = new three.BufferAttribute(new Float32Array(this.rest), 3);
    this.colours = new three.BufferAttribute(new Float32Array(3 * this.nodes), 3);
    this.geometry.setAttribute('position', this.positions);
    this.geometry.setAttribute('color', this.colours);
    this.material = new three.MeshLambertMaterial({
      vertexColors: true,
      side: three.DoubleSide,
      polygonOffset: true,
      polygonOffsetFactor: 1,
      polygonOffsetUnits: 1,
    });
    this.mesh = new three.Mesh(this.geometry, this.material);
    this.group.add(this.mesh, this.outline);
  }
  // Makes a ribbon along the outline, whose width is a ninetieth of the object's size.
  makePlanar() {
    const { three } = this;
    const lines = [];
    for (let i = 0; i < this.elements; ++i) lines.push([this.index[2 * i], this.index[2 * i + 1]]);
    this.lines = lines;
    this.ribbon = this.box.getSize(new three.Vector3()).length() / 90;
    const rest = new three.BufferGeometry();
    rest.setAttribute('position', new three.BufferAttribute(this.rest, 3));
    rest.setIndex(new three.BufferAttribute(this.index, 1));
    this.outline = new three.LineSegments(rest, new three.LineBasicMaterial());
    this.outline.position.z = this.ribbon * 0.4;
    this.geometry = new three.BufferGeometry();
    this.positions = new three.BufferAttribute(new Float32Array(12 * lines.length), 3);
    this.colours = new three.BufferAttribute(new Float32Array(12 * lines.length), 3);
    this.geometry.setAttribute('position', this.positions);
    this.geometry.setAttribute('color', this.colours);
    this.geometry.setIndex(lines.flatMap((_, i) => [4 * i, 4 * i + 1, 4 * i + 2, 4 * i + 2, 4 * i + 1, 4 * i + 3]));
    this.material = new three.MeshBasicMaterial({ vertexColors: true, side: three.DoubleSide });
    this.mesh = new three.Mesh(this.geometry, this.material);
    this.mesh.position.z = this.ribbon * 0.2;
    this.group.add(this.mesh, this.outline);
  }
  // Makes the inside of a planar body from the topology of the displacement field, whose first
  // nodes are those of the outline.
  makeFilling({ rest, triangles }) {
    const { three } = this, geometry = new three.BufferGeometry();
    const [places, colours] = [0, 1].map(() => new three.BufferAttribute(new Float32Array(rest.length), 3));
    geometry.setAttribute('position', places);
    geometry.setAttribute('color', colours);
    this.field = { rest, places, colours };
    geometry.setIndex(new three.BufferAttribute(new Uint32Array(triangles), 1));
    this.filling = new three.Mesh(geometry, new three.MeshBasicMaterial({ vertexColors: true, side: three.DoubleSide }));
    this.filling.frustumCulled = false;
    this.filling.visible = false;
    this.group.add(this.filling);
  }
  // `displacement` x, y, z per node of the field [m]; null: unknown; the inside stays empty.
  fill(displacement) {
    if (!this.field) return;
    this.filling.visible = Boolean(displacement) && this.quantity === 'moved';
    if (!this.filling.visible || (this.filled?.displacement === displacement && this.filled.places === this.places)) return;
    this.filled = { displacement, places: this.places };
    const { rest, places, colours } = this.field, moved = rest.map((value, i) => value + displacement[i]);
    const [[cos, sin], [right, up]] = this.poseOf(moved), full = this.colourScale.full.moved;
    for (let i = 0; i < rest.length; i += 3) {
      const [x, y, z] = moved.subarray(i, i + 3), size = Math.hypot(...displacement.subarray(i, i + 3));
      places.array.set([cos * x - sin * y + right, sin * x + cos * y + up, z], i);
      colours.array.set(viridisLight(size / full), i);
    }
    places.needsUpdate = colours.needsUpdate = true;
  }
  // Returns the object's pose in S, [[cos, sin], [x, y]]: rotation and translation that map the
  // outline in its own frame to `moved`, the outline in S, by least squares.
  poseOf(moved) {
    const { places, nodes } = this;
    const meanOf = (list, axis) => list.reduce((sum, value, i) => (i < 3 * nodes && i % 3 === axis ? sum + value / nodes : sum), 0);
    const [[x, y], [u, v]] = [moved, places].map((list) => [meanOf(list, 0), meanOf(list, 1)]);
    let [dot, cross] = [0, 0];
    for (let i = 0; i < 3 * nodes; i += 3) {
      const [a, b, c, d] = [moved[i] - x, moved[i + 1] - y, places[i] - u, places[i + 1] - v];
      [dot, cross] = [dot + a * c + b * d, cross + a * d - b * c];
    }
    const size = Math.hypot(dot, cross) || 1, [cos, sin] = [dot / size, cross / size];
    return [[cos, sin], [u - cos * x + sin * y, v - sin * x - cos * y]];
  }
  // New positions, three numbers per node [m], and the traction there [Pa]; null: unknown.
  deform(places, traction = null) {
    const moved = new Float32Array(this.nodes), size = this.box.getSize(new this.three.Vector3()).length();
    for (let i = 0; i < this.nodes; ++i) {
      moved[i] = Math.hypot(
        places[3 * i] - this.rest[3 * i],
        places[3 * i + 1] - this.rest[3 * i + 1],
        places[3 * i + 2] - this.rest[3 * i + 2],
      );
    }
    this.measure('moved', moved, 1e-3 * size, SINGLE_PRECISION * size);
    this.measure('traction', traction, MIN_TRACTION, 0);
    Object.assign(this, { places, values: { moved, traction } });
    this.draw();
  }
  draw() {
    if (this.planar) this.drawRibbon(this.places);
    else this.drawSurface(this.places);
  }
  // Sets the colours for `values`. Values below `none` count as zero.
  measure(quantity, values, least, none) {
    const largest = values && values.reduce((most, value) => Math.max(most, value), 0);
    this.largest[quantity] = largest < none ? 0 : largest;
    this.colourScale.raise(quantity, largest, least);
  }
  colourBy(quantity) {
    this.quantity = quantity;
    this.draw();
  }
  colourOf(node) {
    const values = this.values[this.quantity];
    return values ? viridisLight(values[node] / this.colourScale.full[this.quantity]) : UNKNOWN;
  }
  drawSurface(places) {
    this.positions.array.set(places);
    for (let i = 0; i < this.nodes; ++i) this.colours.array.set(this.colourOf(i), 3 * i);
    this.positions.needsUpdate = this.colours.needsUpdate = true;
    this.geometry.computeVertexNormals();
    this.geometry.computeBoundingSphere();
  }
  drawRibbon(places) {
    this.lines.forEach(([a, b], i) => {
      const dx = places[3 * b] - places[3 * a], dy = places[3 * b + 1] - places[3 * a + 1], length = Math.hypot(dx, dy) || 1;
      const nx = (-dy / length) * this.ribbon / 2, ny = (dx / length) * this.ribbon / 2;
      [[a, 1], [a, -1], [b, 1], [b, -1]].forEach(([node, side], corner) => {
        this.positions.array.set(
          [places[3 * node] + side * nx, places[3 * node + 1] + side * ny, places[3 * node + 2]],
          12 * i + 3 * corner,
        );
        this.colours.array.set(this.colourOf(node), 12 * i + 3 * corner);
      });
    });
    this.positions.needsUpdate = this.colours.needsUpdate = true;
    this.geometry.computeBoundingSphere();
  }
  paint({ line }) {
    this.outline.material.color.set(line);
  }
}
