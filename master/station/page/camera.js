// Orthographic view of the object: a pixel is the same length everywhere. Frame S.

export class Camera {
  constructor(three) {
    this.three = three;
    this.camera = new three.OrthographicCamera(-1, 1, 1, -1, -1, 1);
    this.target = new three.Vector3();
    Object.assign(this, { azimuth: -0.6, elevation: 0.42, halfHeight: 1, planar: false, size: 1, width: 1, height: 1 });
  }
  // Fits the view to `box`, the bounding box of everything visible.
  fit(box, planar) {
    this.planar = planar;
    box.getCenter(this.target);
    this.size = Math.max(1e-9, box.getSize(new this.three.Vector3()).length());
    this.look(planar ? 'Z' : 'home');
    this.halfHeight = this.extent(box) * 0.74;
    this.place();
  }
  // Returns the extent of the box in the view's directions; the box must fit into half of the view.
  extent(box) {
    this.place();
    const { right, up } = this.axes(), size = box.getSize(new this.three.Vector3());
    const along = (axis) => Math.abs(axis.x) * size.x + Math.abs(axis.y) * size.y + Math.abs(axis.z) * size.z;
    return Math.max(along(up), (along(right) * this.height) / this.width, 1e-9);
  }
  look(from) {
    const views = { X: [0, 0], Y: [-Math.PI / 2, 0], Z: [-Math.PI / 2, Math.PI / 2], home: [-0.9, 0.38] };
    [this.azimuth, this.elevation] = views[from];
    this.place();
  }
  turn(dx, dy) {
    this.azimuth -= dx * 0.008;
    this.elevation = Math.min(Math.PI / 2, Math.max(-Math.PI / 2, this.elevation + dy * 0.008));
    this.place();
  }
  zoom(factor) {
    this.halfHeight *= factor;
    this.place();
  }
  resize(width, height) {
    Object.assign(this, { width, height });
    this.place();
  }
  axes() {
    const { three, azimuth: a, elevation: e } = this;
    const back = new three.Vector3(Math.cos(e) * Math.cos(a), Math.cos(e) * Math.sin(a), Math.sin(e));
    const right = new three.Vector3(-Math.sin(a), Math.cos(a), 0);
    return { right, up: new three.Vector3().crossVectors(back, right), back };
  }
  place() {
    const { right, up, back } = this.axes(), wide = (this.halfHeight * this.width) / this.height;
    Object.assign(this.camera, {
      left: -wide,
      right: wide,
      top: this.halfHeight,
      bottom: -this.halfHeight,
      near: -10 * this.size,
      far: 10 * this.size,
    });
    this.camera.position.copy(this.target);
    this.camera.quaternion.setFromRotationMatrix(new this.three.Matrix4().makeBasis(right, up, back));
    this.camera.updateProjectionMatrix();
    this.camera.updateMatrixWorld();
  }
  get metresPerPixel() {
    return (2 * this.halfHeight) / this.height;
  }
  // Returns the position of a point of S in the image [px].
  toPixels(place) {
    const p = new this.three.Vector3(...place).project(this.camera);
    return [((p.x + 1) / 2) * this.width, ((1 - p.y) / 2) * this.height];
  }
  // Returns the displacement in S [m] for a drag by (dx, dy) [px]. For a solid body it is along the
  // axes of S that are closest to the image's axes, with the length of the cursor's motion.
  drag(dx, dy, dz) {
    const { right, up, back } = this.axes(), scale = this.metresPerPixel;
    if (this.planar) return [right.x * dx * scale - up.x * dy * scale, right.y * dx * scale - up.y * dy * scale, 0];
    const used = new Set(), move = [0, 0, 0];
    for (const [axis, pixels] of [[up, -dy], [right, dx], [back, -dz]]) {
      const parts = [axis.x, axis.y, axis.z].map((part, i) => (used.has(i) ? 0 : Math.abs(part)));
      const i = parts.indexOf(Math.max(...parts)), part = [axis.x, axis.y, axis.z][i];
      used.add(i);
      move[i] += (pixels * scale) / (axis === back ? Math.sign(part) || 1 : part);
    }
    return move;
  }
}
