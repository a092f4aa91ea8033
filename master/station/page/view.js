// Draws object, tool, and the force as an arrow by three.js, if it was built in.
import { Body } from './body.js';
import { Camera } from './camera.js';
import { viridisBar } from './colours.js';
import { LATER_S, ageWords, figure, fixed, lengthUnit, norm, stressUnit, write, xyz } from './text.js';

const ARROW_SHARE = 0.15;   // length at the force limit, relative to the object's size
const MIN_ARROW = 0.005;  // smallest force that is drawn, relative to the limit
const TOGETHER_S = 0.5;     // largest time between shape and displacement of one moment
// Offset of the positions in a shape [bytes]; validity without a solution of the model.
const PLACES_AT = 20, FAILED = 5;

const colour = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

// Returns whether there is no graphics card: then smooth edges would cost more than everything
// else.
function drawsInSoftware() {
  const probe = document.createElement('canvas').getContext('webgl2'), debugInfo = probe?.getExtension('WEBGL_debug_renderer_info');
  const name = debugInfo ? probe.getParameter(debugInfo.UNMASKED_RENDERER_WEBGL) : '';
  probe?.getExtension('WEBGL_lose_context')?.loseContext();
  return /swiftshader|llvmpipe|software/i.test(name);
}

export class View {
  constructor(link, colourScale) {
    Object.assign(this, { link, colourScale, past: null, fieldTopology: null, field: null });
    this.host = document.getElementById('view');
    this.line = document.getElementById('view-line');
    this.label = this.add('force-label');
    this.bar = this.add('colour-bar');
    this.bar.innerHTML = '<b></b><i></i><b>0</b><em></em>';
    this.bar.querySelector('i').style.background = viridisBar();
    this.bar.hidden = this.label.hidden = true;
    Object.assign(this, { forceScale: 1, body: null, shape: null, shapeT: null, dirty: false, status: null });
  }
  add(name) {
    const part = document.createElement('div');
    part.className = name;
    this.host.append(part);
    return part;
  }
  say(text) {
    const words = this.add('empty');
    words.textContent = text;
    return words;
  }
  async load(isBuiltIn) {
    if (!isBuiltIn)
      return void this.say('Built without 3D. With npm: deploy/page.sh, then build again. Dragging here still moves the tool.');
    this.waiting = this.say('No shape received yet.');
    const three = await import('/lib/three.module.js');
    try {
      this.drawsInSoftware = drawsInSoftware();
      this.renderer = new three.WebGLRenderer({ antialias: !this.drawsInSoftware, alpha: true });
    } catch {
      this.waiting.textContent = 'This browser shows no 3D (WebGL is off). Dragging here still moves the tool.';
      return;
    }
    this.three = three;
    this.host.prepend(this.renderer.domElement);
    this.camera = new Camera(three);
    this.scene = new three.Scene();
    this.furnish();
    this.takeWorkspace();
    this.repaint();
    if (this.topology) this.takeTopology(this.topology);
    new ResizeObserver(() => this.resize()).observe(this.host);
    this.resize();
  }
  furnish() {
    const { three, scene } = this;
    scene.add(new three.HemisphereLight(0xffffff, 0x667788, 2.2));
    this.sun = new three.DirectionalLight(0xffffff, 1.6);
    scene.add(this.sun);
    const ball = new three.SphereGeometry(1, 24, 16);
    this.tip = new three.Mesh(ball, new three.MeshLambertMaterial({ transparent: true }));
    this.hand = new three.Mesh(ball, new three.MeshBasicMaterial({ wireframe: true, transparent: true, opacity: 0.5 }));
    this.spring = new three.Line(
      new three.BufferGeometry().setFromPoints([new three.Vector3(), new three.Vector3()]),
      new three.LineBasicMaterial(),
    );
    this.arrow = this.makeArrow();
    const circle = Array.from({ length: 48 }, (_, i) => new three.Vector3(Math.cos((i * Math.PI) / 24), Math.sin((i * Math.PI) / 24), 0));
    this.tangent = new three.LineLoop(new three.BufferGeometry().setFromPoints(circle), new three.LineBasicMaterial());
    this.others = [];  // other fingertips, each a ball and an arrow
    this.workspace = new three.Box3Helper(new three.Box3());
    this.workspace.visible = false;
    scene.add(this.workspace);
    const parts = [this.tip, this.hand, this.spring, this.arrow, this.tangent];
    scene.add(...parts);
    for (const part of parts) part.visible = false;
  }
  // Makes an arrow of length one along y.
  makeArrow() {
    const { three } = this, arrow = new three.Group(), material = new three.MeshBasicMaterial({ depthTest: false });
    const shaft = new three.Mesh(new three.CylinderGeometry(0.035, 0.035, 0.72, 12).translate(0, 0.36, 0), material);
    const head = new three.Mesh(new three.ConeGeometry(0.11, 0.28, 20).translate(0, 0.86, 0), material);
    arrow.add(shaft, head);
    arrow.renderOrder = shaft.renderOrder = head.renderOrder = 2;
    arrow.material = material;
    return arrow;
  }
  repaint() {
    if (!this.three) return;
    this.tip.material.color.set(colour('--tool'));
    this.tangent.material.color.set(colour('--tool'));
    this.hand.material.color.set(colour('--dim'));
    this.spring.material.color.set(colour('--dim'));
    this.workspace.material.color.set(colour('--rest'));
    for (const arrow of [this.arrow, ...this.others.map(([, own]) => own)]) arrow.material.color.set(colour('--force'));
    for (const [ball] of this.others) ball.material.color.set(colour('--rest'));
    this.body?.paint({ line: colour('--rest') });
    this.dirty = true;
  }
  resize() {
    if (!this.renderer || !this.host.clientWidth) return;
    this.renderer.setPixelRatio(this.drawsInSoftware ? 1 : Math.min(window.devicePixelRatio, 2));
    this.renderer.setSize(this.host.clientWidth, this.host.clientHeight);
    this.camera.resize(this.host.clientWidth, this.host.clientHeight);
    if (this.body && !this.looked) this.fit();
    this.dirty = true;
  }
  takeTopology(message) {
    this.topology = message;
    if (!this.three) return;
    if (this.body) {
      this.scene.remove(this.body.group);
      this.body.dispose();
    }
    this.shape = null;
    this.colourScale.begin();
    this.body = new Body(this.three, message, this.colourScale, this.body?.quantity);
    this.scene.add(this.body.group);
    if (this.fieldTopology?.number === message.number) this.takeFieldTopology(this.fieldTopology);
    this.waiting.hidden = true;
    this.bar.hidden = false;
    this.repaint();
    this.fit();
  }
  // Shows the workspace of the tool from the slave's capabilities; zeros may be absent.
  takeWorkspace(capabilities) {
    if (capabilities)
      this.limits = [capabilities.workspace_min, capabilities.workspace_max].map((corner) =>
        ['x', 'y', 'z'].map((axis) => corner?.[axis] ?? 0),
      );
    if (!this.three || !this.limits) return;
    const [low, high] = this.limits;
    this.workspace.box.min.set(...low);
    this.workspace.box.max.set(...high);
    this.workspace.visible = low.some((part, i) => high[i] > part);
    this.dirty = true;
  }
  // `topology`: the result of fieldTopologyOf (link.js).
  takeFieldTopology(topology) {
    this.fieldTopology = topology;
    if (this.body?.planar && this.body.number === topology.number) this.body.makeFilling(topology);
  }
  // `field`: the result of fieldOf (link.js).
  takeField(field) {
    this.field = field;
    this.dirty = true;
  }
  // Shows a moment of the last minute, {shape, status, field}; null: the newest one again.
  showPast(past) {
    const wasPast = Boolean(this.past);
    this.past = past;
    if (!past && !wasPast) return;
    const shape = past ? past.shape : this.newest;
    if (shape) this.takeShape(shape, Boolean(past));
    this.dirty = true;
  }
  takeShape(message, isPast = false) {
    if (!isPast) this.newest = message;
    if (Boolean(this.past) !== isPast) return;
    if (!this.body || message.number !== this.body.number) return;
    const { nodes } = this.body;
    if (![PLACES_AT + 12 * nodes, PLACES_AT + 16 * nodes].includes(message.buffer.byteLength)) return;
    this.shape = message;
    this.dirty = true;
  }
  take(status) {
    this.status = status;
    this.dirty = true;
  }
  // Ignores a shape of a later moment.
  forgetShape() {
    this.shapeT = null;
    this.body?.deform(this.body.rest);
    this.dirty = true;
  }
  // Hides the force, which is unknown without a connection to the master.
  forget() {
    this.status = null;
    for (const arrow of [this.arrow, ...(this.others || []).map(([, own]) => own)]) if (arrow) arrow.visible = false;
    this.dirty = true;
  }
  // Applies the newest shape and status just before drawing.
  put() {
    const status = this.past ? this.past.status : this.status, { shape } = this;
    this.shape = null;
    if (shape) {
      const end = PLACES_AT + 12 * this.body.nodes, hasTraction = shape.buffer.byteLength > end;
      this.body.deform(
        new Float32Array(shape.buffer.slice(PLACES_AT, end)),
        hasTraction ? new Float32Array(shape.buffer.slice(end)) : null,
      );
      this.shapeT = shape.t;
      this.isAnswered = shape.view.getUint32(16, true) !== FAILED;
    }
    const field = this.past ? this.past.field : this.field;
    this.body?.fill(field && Math.abs(field.t - this.shapeT) < TOGETHER_S ? field.displacement : null);
    if (!this.body || !status?.fingers.length) return;
    this.size = this.body.box.getSize(new this.three.Vector3()).length();
    const state = status.slave_state, model = state?.local_model, tip = state ? xyz(state.p_S_tip) : status.fingers[0].place;
    this.putBall(this.tip, tip, 0.016);
    this.tip.material.opacity = state?.validity === 'VALIDITY_STALE' ? 0.3 : 1;
    this.putBall(this.hand, status.p_S, 0.02);
    this.spring.visible = true;
    this.spring.geometry.setFromPoints([new this.three.Vector3(...tip), new this.three.Vector3(...status.p_S)]);
    this.tangent.visible = Boolean(model?.in_contact && model.normal);
    if (this.tangent.visible) this.putTangent(tip, xyz(model.normal));
    const limit = status.force_limit || 1;
    this.putArrow(status, tip, limit);
    this.putOthers(status.fingers.slice(1), limit);
  }
  // Places the tangent plane of the local model.
  putTangent(tip, normal) {
    this.tangent.position.set(...tip);
    this.tangent.scale.setScalar(0.06 * this.size);
    this.tangent.quaternion.setFromUnitVectors(new this.three.Vector3(0, 0, 1), new this.three.Vector3(...normal).normalize());
  }
  putBall(ball, place, share) {
    ball.visible = true;
    ball.position.set(...place);
    ball.scale.setScalar(share * this.size);
  }
  // Draws the force of the object on the tool: its direction is that of the local force, its length
  // that of the force on the device.
  putArrow(status, tip, limit) {
    const force = status.chain.local, size = norm(force), hand = norm(status.chain.sent);
    this.arrow.visible = status.state === 'FOLLOWING' && size > 1e-9 && hand > MIN_ARROW * limit;
    if (!this.arrow.visible) return;
    const length = this.aim(this.arrow, tip, force, hand / limit);
    this.arrowEnd = new this.three.Vector3(...force).setLength(length).add(this.arrow.position);
  }
  putOthers(fingers, limit) {
    const { three } = this;
    while (this.others.length < fingers.length) {
      const pair = [this.tip.clone(), this.makeArrow()];
      // Visible through the object.
      pair[0].material = new three.MeshLambertMaterial({ transparent: true, opacity: 0.6, depthTest: false });
      pair[0].material.color.set(colour('--rest'));
      pair[1].material.color.set(colour('--force'));
      this.others.push(pair);
      this.scene.add(...pair);
    }
    fingers.forEach(({ place, force }, i) => {
      const [ball, arrow] = this.others[i], size = force ? norm(force) * this.forceScale : 0;
      this.putBall(ball, place, 0.016);
      arrow.visible = size > MIN_ARROW * limit;
      if (arrow.visible) this.aim(arrow, place, force, size / limit);
    });
  }
  // Sets direction and length of an arrow. `share`: force relative to the limit.
  aim(arrow, place, force, share) {
    const length = this.size * (0.05 + ARROW_SHARE * Math.min(1, share));
    arrow.position.set(...place);
    arrow.scale.setScalar(length);
    arrow.quaternion.setFromUnitVectors(new this.three.Vector3(0, 1, 0), new this.three.Vector3(...force).normalize());
    return length;
  }
  // Draws if there is something new.
  draw() {
    if (!this.renderer || !this.dirty) return;
    this.dirty = false;
    this.put();
    const { back, up, right } = this.camera.axes();
    this.sun.position
      .copy(this.camera.target)
      .addScaledVector(back, this.camera.size)
      .addScaledVector(up, 0.7 * this.camera.size)
      .addScaledVector(right, -0.5 * this.camera.size);
    this.sun.target.position.copy(this.camera.target);
    this.sun.target.updateMatrixWorld();
    this.renderer.render(this.scene, this.camera.camera);
    if (this.body) this.host.dataset.metresPerPixel = this.camera.metresPerPixel;
    this.placeLabel();
  }
  placeLabel() {
    if (this.label.hidden) return;
    const [x, y] = this.camera.toPixels(this.arrowEnd.toArray());
    const left = Math.min(Math.max(x + 10, 4), this.camera.width - 90), top = Math.min(Math.max(y - 14, 4), this.camera.height - 30);
    this.label.style.transform = `translate(${left.toFixed(1)}px, ${top.toFixed(1)}px)`;
  }
  // The label always shows the newest force, even if the view is drawn rarely.
  showForce() {
    const status = this.past ? this.past.status : this.status, hand = status ? norm(status.chain.sent) : 0, limit = status?.force_limit || 1;
    const shown = Boolean(this.arrow?.visible) && status?.state === 'FOLLOWING' && hand > MIN_ARROW * limit;
    if (shown === this.label.hidden) this.label.hidden = !shown;
    const press = shown ? Math.min(1, hand / limit).toFixed(2) : '0';
    if (press !== this.press) this.host.style.setProperty('--press', (this.press = press));
    if (!shown) return;
    write(this.label, `${fixed(hand)} N`);
    this.placeLabel();
  }
  showWords() {
    this.showForce();
    const now = this.past ? null : this.link.now();
    const age = this.shapeT === null || now === null ? null : now - this.shapeT;
    if (age < -LATER_S && this.status?.replay) this.forgetShape();
    write(document.getElementById('model-age'), this.past ? this.past.words : this.shapeT === null ? '' : ageWords(age, false));
    if (!this.body) {
      if (this.waiting && this.status?.mesh_trouble) this.waiting.textContent = `No shape: ${this.status.mesh_trouble}`;
      return;
    }
    const { quantity, largest } = this.body, { full } = this.colourScale, isMoved = quantity === 'moved';
    const { unit, factor } = (isMoved ? lengthUnit : stressUnit)(full[quantity]);
    const [top, , , name] = this.bar.children;
    write(top, figure(full[quantity] * factor));
    write(name, `${isMoved ? 'displacement' : quantity}, ${unit}`);
    const what = isMoved ? 'moved by' : 'traction', most = largest[quantity];
    const words =
      this.shapeT === null
        ? 'no shape for this moment'
        : most === null
          ? 'no traction: a force is unknown, or the object has no fixed nodes'
          : `${what} up to ${figure(most * factor)} ${unit}`;
    const old = this.isAnswered === false ? 'the model has no solution here: its last shape; ' : '';
    write(
      this.line,
      `${old}${words}; grey: at rest${this.body.held.length ? '; dots: fixed' : ''}; ball: measured tool; wire: commanded ` +
      'tool; ring: local model; outer box: workspace',
    );
  }
  // Returns the direction of a drag on the screen that presses the tool into the object. Empty:
  // unknown, or in contact.
  wayToPress() {
    if (!this.body || !this.camera || !this.status?.slave_state) return '';
    const { min, max } = this.body.box, tip = xyz(this.status.slave_state.p_S_tip);
    const gaps = ['x', 'y', 'z'].map((axis, i) => Math.max(0, min[axis] - tip[i]) - Math.max(0, tip[i] - max[axis]));
    const [[axis, gap]] = gaps.map((part, i) => [i, part]).sort(([, a], [, b]) => Math.abs(b) - Math.abs(a));
    if (gap === 0) return '';
    const there = tip.map((part, i) => (i === axis ? part + gap : part));
    const [[fromX, fromY], [toX, toY]] = [tip, there].map((place) => this.camera.toPixels(place));
    const [dx, dy] = [toX - fromX, toY - fromY];
    if (Math.abs(dx) > Math.abs(dy)) return dx > 0 ? 'to the right' : 'to the left';
    return dy > 0 ? 'down' : 'up';
  }
  // Switches the colours between displacement and traction.
  toggleColours() {
    if (!this.body) return;
    this.body.colourBy(this.body.quantity === 'moved' ? 'traction' : 'moved');
    document.getElementById('colours').setAttribute('aria-pressed', String(this.body.quantity === 'traction'));
    this.dirty = true;
  }
  fit() {
    if (!this.body) return;
    this.looked = false;
    this.camera.fit(this.body.box, this.body.planar);
    this.dirty = true;
  }
  look(from) {
    if (!this.camera) return;
    this.looked = true;
    this.camera.look(from);
    this.dirty = true;
  }
  turn(dx, dy) {
    if (!this.camera) return;
    this.looked = true;
    this.camera.turn(dx, dy);
    this.dirty = true;
  }
  zoom(factor) {
    if (!this.camera) return;
    this.looked = true;
    this.camera.zoom(factor);
    this.dirty = true;
  }
  toggleWire() {
    if (!this.body) return;
    this.body.material.wireframe = !this.body.material.wireframe;
    this.dirty = true;
  }
  // Returns the motion of a drag in S [m]. Without a view of the object a pixel is a quarter of a
  // millimetre.
  drag(dx, dy, dz = 0) {
    if (this.camera && this.body) return this.camera.drag(dx, dy, dz);
    return [dx * 2.5e-4, -dy * 2.5e-4, dz * 2.5e-4];
  }
}
