// The coloured workspace: the free faces of its cells, and the face of the plane that cuts it.
import {
  BufferAttribute,
  BufferGeometry,
  Data3DTexture,
  DoubleSide,
  Group,
  Mesh,
  MeshBasicMaterial,
  NearestFilter,
  Plane,
  PlaneGeometry,
  RedFormat,
  ShaderMaterial,
  Vector3,
} from "three";

// Outward direction of each face of a cell, two directions along the face, and its brightness: the eye sees edges where neighbours have one colour.
const FACES = [
  { out: [1, 0, 0], across: [0, 1, 0], up: [0, 0, 1], shade: 0.92 },
  { out: [-1, 0, 0], across: [0, 0, 1], up: [0, 1, 0], shade: 0.92 },
  { out: [0, 1, 0], across: [0, 0, 1], up: [1, 0, 0], shade: 0.86 },
  { out: [0, -1, 0], across: [1, 0, 0], up: [0, 0, 1], shade: 0.86 },
  { out: [0, 0, 1], across: [1, 0, 0], up: [0, 1, 0], shade: 1 },
  { out: [0, 0, -1], across: [0, 1, 0], up: [1, 0, 0], shade: 0.8 },
];
const VERTEX = `varying vec3 at;
void main() { vec4 world = modelMatrix * vec4(position, 1.0); at = world.xyz; gl_Position = projectionMatrix * viewMatrix * world; }`;
// Unlit, so that a pixel has the colour of the legend. A cell is looked up slightly behind the plane: a plane between two cells shows the one that is kept.
const FRAGMENT = `uniform sampler3D classes; uniform vec3 low, inward; uniform float edge; uniform vec3 colours[8]; varying vec3 at;
void main() {
  ivec3 cell = ivec3(floor((at - low) / edge + 0.002 * inward));
  if (any(lessThan(cell, ivec3(0))) || any(greaterThanEqual(cell, textureSize(classes, 0)))) discard;
  int k = int(texelFetch(classes, cell, 0).r * 255.0 + 0.5);
  if (k == 0) discard;
  gl_FragColor = vec4(colours[k], 1.0);
}`;

// `cells` has edge and low (m), shape (x, y, z), and classes: a byte a cell, x fastest, 0 where the tool never is, else the class from 1.
export class Cells {
  constructor(cells) {
    this.cells = cells;
    this.plane = new Plane();
    const texture = new Data3DTexture(cells.classes, ...cells.shape);
    texture.format = RedFormat;
    texture.minFilter = texture.magFilter = NearestFilter;
    texture.unpackAlignment = 1;
    texture.needsUpdate = true;
    this.uniforms = {
      classes: { value: texture },
      low: { value: new Vector3(...cells.low) },
      inward: { value: new Vector3() },
      edge: { value: cells.edge },
      colours: { value: [] },
    };
    const size = 2 * cells.edge * Math.hypot(...cells.shape);
    const cut = new ShaderMaterial({ vertexShader: VERTEX, fragmentShader: FRAGMENT, uniforms: this.uniforms, side: DoubleSide });
    this.face = new Mesh(new PlaneGeometry(size, size), cut);
    this.shell = new Mesh(new BufferGeometry(), new MeshBasicMaterial({ vertexColors: true }));
    this.group = new Group().add(this.shell, this.face);
  }

  // Take the colours of the classes, from small to large error.
  colour(colours) {
    this.uniforms.colours.value = [colours[0], ...colours];
    const { classes, shape, low, edge } = this.cells;
    const [nx, ny, nz] = shape;
    const strides = [1, nx, nx * ny];
    const positions = [];
    const shades = [];
    const indices = [];
    for (let z = 0, k = 0; z < nz; z++)
      for (let y = 0; y < ny; y++)
        for (let x = 0; x < nx; x++, k++) {
          if (!classes[k]) continue;
          const here = [x, y, z];
          for (const { out, across, up, shade } of FACES) {
            const axis = out.findIndex(Boolean);
            const next = here[axis] + out[axis];
            if (next >= 0 && next < shape[axis] && classes[k + out[axis] * strides[axis]]) continue;
            const first = positions.length / 3;
            for (const [a, b] of [[0, 0], [1, 0], [1, 1], [0, 1]]) {
              for (let i = 0; i < 3; i++) positions.push(low[i] + edge * (here[i] + Math.max(out[i], 0) + a * across[i] + b * up[i]));
              const { r, g, b: blue } = colours[classes[k] - 1];
              shades.push(r * shade, g * shade, blue * shade);
            }
            indices.push(first, first + 1, first + 2, first, first + 2, first + 3);
          }
        }
    this.shell.geometry.dispose();
    this.shell.geometry = new BufferGeometry()
      .setAttribute("position", new BufferAttribute(new Float32Array(positions), 3))
      .setAttribute("color", new BufferAttribute(new Float32Array(shades), 3))
      .setIndex(indices);
  }

  // Remove the cells on the side of a plane to which its normal points; without a normal, show all.
  cut(normal, distance) {
    this.face.visible = Boolean(normal);
    this.shell.material.clippingPlanes = normal ? [this.plane] : null;
    if (!normal) return;
    this.plane.set(normal.clone().negate(), distance);
    this.uniforms.inward.value.copy(normal).negate();
    this.plane.projectPoint(this.middle(), this.face.position);
    this.face.quaternion.setFromUnitVectors(new Vector3(0, 0, 1), normal);
  }

  // Return corners of cells that are not cut away.
  visible() {
    const { position } = this.shell.geometry.attributes;
    const points = [];
    for (let k = 0; k < position.count; k++) points.push(new Vector3().fromBufferAttribute(position, k));
    return this.group.visible ? points.filter((point) => !this.face.visible || this.plane.distanceToPoint(point) >= 0) : [];
  }

  middle() {
    const { low, edge, shape } = this.cells;
    return new Vector3(...low.map((start, i) => start + (edge * shape[i]) / 2));
  }

  // Return the ends of the workspace along a direction, m.
  extent(direction) {
    const { low, edge, shape } = this.cells;
    const ends = [0, 0];
    for (let i = 0; i < 3; i++) {
      const both = [low[i], low[i] + edge * shape[i]].map((end) => end * direction.getComponent(i)).sort((a, b) => a - b);
      ends[0] += both[0];
      ends[1] += both[1];
    }
    return ends;
  }
}
