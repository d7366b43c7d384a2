// The picture: the arm at a pose, its error, the workspace behind the cut, the floor; and the camera.
import {
  BackSide,
  BoxGeometry,
  BufferGeometry,
  Color,
  ColorManagement,
  ConeGeometry,
  CylinderGeometry,
  DirectionalLight,
  GreaterDepth,
  GridHelper,
  Group,
  HemisphereLight,
  LinearSRGBColorSpace,
  LineBasicMaterial,
  LineSegments,
  Matrix4,
  Mesh,
  MeshBasicMaterial,
  MeshLambertMaterial,
  PerspectiveCamera,
  Quaternion,
  Scene,
  SphereGeometry,
  Vector3,
  WebGLRenderer,
} from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";
import { Cells } from "./cells.js";

// Colours are those of the page's style, byte by byte: nothing is converted.
ColorManagement.enabled = false;
const Y = new Vector3(0, 1, 0);
const Z = new Vector3(0, 0, 1);
const NAMES = ["paper", "line", "quiet", "tube", "joint", "base", "warn", "design"];
const vector = (values) => new Vector3(...values);
const matrix = (rows) => new Matrix4().set(...rows, 0, 0, 0, 1);

// Return a body of the arm in its own axes: z along its length, `near` and `far` the widths and heights of its ends.
function bodyGeometry({ form, near, far, length }) {
  const shape = { round: () => new CylinderGeometry(0.5, 0.5, 1, 48).rotateX(Math.PI / 2), box: () => new BoxGeometry(1, 1, 1), sphere: () => new SphereGeometry(0.5, 32, 20) };
  const made = shape[form]();
  const points = made.attributes.position;
  for (let k = 0; k < points.count; k++) {
    const share = points.getZ(k) + 0.5;
    const [width, height] = near.map((size, i) => size + share * (far[i] - size));
    points.setXYZ(k, points.getX(k) * width, points.getY(k) * height, points.getZ(k) * length);
  }
  if (form !== "sphere" && near.some((size, i) => size !== far[i])) made.computeVertexNormals();
  return made;
}

export class Picture {
  constructor(stage, data) {
    this.stage = stage;
    this.data = data;
    this.renderer = new WebGLRenderer({ antialias: true, alpha: true });
    this.renderer.outputColorSpace = LinearSRGBColorSpace;
    this.renderer.localClippingEnabled = true;
    this.canvas = this.renderer.domElement;
    this.camera = new PerspectiveCamera(28, 1, 0.01, 100);
    this.camera.up.copy(Z);
    this.controls = new OrbitControls(this.camera, this.canvas);
    Object.assign(this.controls, { enablePan: false, enableZoom: false, enableDamping: false });
    this.canvas.style.touchAction = "pan-y"; // on a phone the page scrolls on under the finger
    this.controls.addEventListener("change", () => this.paint());
    this.scene = new Scene();
    const sun = new DirectionalLight(0xffffff, 1.6);
    sun.position.set(2, -3, 4);
    this.arm = new Group();
    this.fixed = new Group();
    this.cells = data.cells && new Cells(data.cells);
    this.scene.add(new HemisphereLight(0xffffff, 0x777f88, 1.7), sun, this.arm, this.fixed);
    if (this.cells) this.scene.add(this.cells.group);
    this.geometries = data.bodies.map(bodyGeometry);
    this.low = vector(data.low);
    this.high = vector(data.high);
    this.size = data.size;
    Object.assign(this.controls, { minDistance: 0.3 * this.size, maxDistance: 6 * this.size });
    this.camera.far = 20 * this.size;
    this.camera.near = 0.005 * this.size;
    stage.append(this.canvas);
    new ResizeObserver(() => this.resize()).observe(stage);
  }

  // Take the colours of the page's style, which has two schemes.
  theme() {
    const style = getComputedStyle(this.stage);
    const colour = (name) => new Color(style.getPropertyValue(`--${name}`).trim());
    this.colours = Object.fromEntries(NAMES.map((name) => [name, colour(name)]));
    if (this.cells) this.cells.colour([0, 1, 2, 3, 4, 5, 6].map((k) => colour(`c${k}`)));
    this.fixed.clear();
    const { floor } = this.data;
    const cell = floor.cell;
    const grid = new GridHelper(20 * cell, 20, this.colours.line, this.colours.line);
    grid.rotation.x = Math.PI / 2;
    grid.position.set(0, 0, floor.z);
    const ends = [0, 1, 2].flatMap((k) => [new Vector3(), new Vector3().setComponent(k, cell)]);
    const axes = new LineSegments(new BufferGeometry().setFromPoints(ends), new LineBasicMaterial({ color: this.colours.quiet }));
    axes.position.set(0, 0, floor.z + 1e-3 * this.size);
    this.fixed.add(grid, axes);
  }

  // Show the arm at a pose, with its error.
  pose(pose) {
    const { warn, paper, design, tube, joint, base } = this.colours;
    const of = { link: tube, offset: tube, joint, base, rail: base, tool: tube, payload: design, point: warn };
    this.arm.clear();
    this.data.bodies.forEach((body, k) => this.solid(this.geometries[k], of[body.kind], matrix(pose.bodies[k])));
    const tool = vector(pose.tool);
    const error = vector(pose.error);
    const along = error.clone().normalize();
    const turn = new Quaternion().setFromUnitVectors(Y, error.length() ? along : Y);
    const thick = 0.0035 * this.size;
    const end = tool.clone().add(error);
    const head = Math.min(7 * thick, 0.6 * error.length());
    if (error.length() > 1e-3 * this.size)
      for (const [grow, material] of [[0.5, { color: paper, side: BackSide }], [0, { color: warn }]]) {
        const wide = thick * (1 + grow);
        const shaft = new CylinderGeometry(wide, wide, error.length() - head, 20).translate(0, (error.length() - head) / 2, 0);
        const tip = new ConeGeometry(2.8 * thick * (1 + grow / 2), head * (1 + grow / 3), 28).translate(0, error.length() - head / 2, 0);
        for (const each of [shaft, tip]) this.add(new Mesh(each, new MeshBasicMaterial({ ...material, transparent: true })), turn, tool);
      }
    const cloud = new MeshLambertMaterial({ color: warn, transparent: true, opacity: 0.4, depthWrite: false });
    const ellipsoid = new Mesh(new SphereGeometry(1, 40, 24), cloud);
    ellipsoid.matrixAutoUpdate = false;
    ellipsoid.matrix.makeBasis(...pose.axes.map(vector)).setPosition(end);
    ellipsoid.renderOrder = 3;
    this.arm.add(ellipsoid);
  }

  add(mesh, turn, at) {
    mesh.quaternion.copy(turn);
    mesh.position.copy(at);
    mesh.renderOrder = 2;
    this.arm.add(mesh);
  }

  // A body in front of the workspace, and faintly where the workspace hides it.
  solid(geometry, color, place) {
    const hidden = new MeshBasicMaterial({ color, transparent: true, opacity: 0.55, depthFunc: GreaterDepth, depthWrite: false });
    for (const [order, material] of [[1, hidden], [2, new MeshLambertMaterial({ color, transparent: true })]]) {
      const mesh = new Mesh(geometry, material);
      mesh.matrixAutoUpdate = false;
      mesh.matrix.copy(place);
      mesh.renderOrder = order;
      this.arm.add(mesh);
    }
  }

  // Look along a direction, which points to the camera, from where the arm and the visible part of the workspace fill the picture.
  look(direction) {
    this.camera.position.copy(direction);
    this.camera.lookAt(0, 0, 0);
    this.camera.updateMatrix();
    const axes = [0, 1, 2].map((k) => new Vector3().setFromMatrixColumn(this.camera.matrix, k));
    const corners = Array.from({ length: 8 }, (_, k) => new Vector3(...[0, 1, 2].map((i) => (k & (1 << i) ? this.high : this.low).getComponent(i))));
    const seen = [...corners, ...(this.cells?.visible() ?? [])].map((point) => axes.map((axis) => point.dot(axis)));
    const middle = axes.map((_, k) => {
      const values = seen.map((point) => point[k]);
      return (values.reduce((a, b) => Math.min(a, b)) + values.reduce((a, b) => Math.max(a, b))) / 2;
    });
    const tangent = Math.tan((this.camera.fov * Math.PI) / 360);
    const far = seen
      .map((point) => point.map((value, k) => value - middle[k]))
      .map(([right, up, back]) => Math.max(Math.abs(up), Math.abs(right) / this.camera.aspect) / tangent + back)
      .reduce((a, b) => Math.max(a, b));
    this.controls.target.set(0, 0, 0);
    axes.forEach((axis, k) => this.controls.target.addScaledVector(axis, middle[k]));
    this.camera.position.copy(this.controls.target).addScaledVector(axes[2], 1.04 * far);
    this.controls.update();
  }

  // Turn the camera about the middle by angles to the left and upwards, rad, and multiply its distance.
  turn(left, up, nearer) {
    const from = this.camera.position.clone().sub(this.controls.target);
    from.applyAxisAngle(Z, left);
    const side = new Vector3().crossVectors(Z, from).normalize();
    const lifted = from.clone().applyAxisAngle(side, -up);
    if (Math.abs(lifted.angleTo(Z) - Math.PI / 2) < Math.PI / 2 - 0.05) from.copy(lifted);
    this.camera.position.copy(this.controls.target).addScaledVector(from, nearer);
    this.controls.update();
  }

  resize() {
    const { clientWidth: width, clientHeight: height } = this.stage;
    if (!width || !height) return;
    this.renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    this.draw();
  }

  paint() {
    this.queued ??= requestAnimationFrame(() => this.draw());
  }

  draw() {
    this.queued = undefined;
    this.renderer.render(this.scene, this.camera);
  }
}
