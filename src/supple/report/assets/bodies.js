// Bodies: nodes and shapes are stored once on the graphics unit, which moves the nodes at every frame:
//     x = p + R (X + gain sum_k a_k(t) shape_k)

const {
  BufferAttribute,
  BufferGeometry,
  Color,
  DataArrayTexture,
  DataTexture,
  DoubleSide,
  FloatType,
  GLSL3,
  Group,
  LineSegments,
  Mesh,
  PerspectiveCamera,
  Points,
  Quaternion,
  RedFormat,
  RedIntegerFormat,
  RGBAIntegerFormat,
  Scene,
  ShaderMaterial,
  ShortType,
  Vector3,
  WebGLRenderer,
  OrbitControls,
  uPlot,
} = Libraries;

const MOVED = `
precision highp isampler2DArray;
uniform isampler2DArray shapes, fieldShapes;
uniform highp sampler2D amplitudes, fieldAmplitudes;
uniform int count, fieldCount, across, rows, perLayer;
uniform float gain;
in float unknown;
out vec3 seen;
out float value, missing;
ivec3 at(int k) {
  return ivec3(gl_VertexID % across, (k % perLayer) * rows + gl_VertexID / across, k / perLayer);
}
void main() {
  vec3 moved = vec3(0.0);
  for (int k = 0; k < count; k++)
    moved += texelFetch(amplitudes, ivec2(k, 0), 0).r * vec3(texelFetch(shapes, at(k), 0).xyz);
  value = length(moved);
  missing = fieldCount >= 0 ? unknown : 0.0;
  if (fieldCount >= 0) {
    value = 0.0;
    for (int k = 0; k < fieldCount; k++)
      value += texelFetch(fieldAmplitudes, ivec2(k, 0), 0).r * float(texelFetch(fieldShapes, at(k), 0).r);
  }
  vec4 place = modelViewMatrix * vec4(position + gain * moved, 1.0);
  seen = place.xyz;
  gl_Position = projectionMatrix * place;
  gl_PointSize = 4.0;
}`;

const SHADED = `
precision highp float;
uniform vec3 ramp[${RAMP.length}];
uniform vec3 plain;
uniform float low, high;
uniform bool coloured, lit;
in vec3 seen;
in float value, missing;
out vec4 colour;
void main() {
  vec3 own = plain;
  if (coloured && missing < 0.5) {
    float place = clamp((value - low) / max(high - low, 1e-30), 0.0, 1.0) * ${(RAMP.length - 1).toFixed(1)};
    int below = min(int(place), ${RAMP.length - 2});
    own = mix(ramp[below], ramp[below + 1], place - float(below));
  }
  if (lit) {
    vec3 normal = normalize(cross(dFdx(seen), dFdy(seen)));
    own *= 0.4 + 0.6 * abs(dot(normal, normalize(seen)));
  }
  colour = vec4(own, 1.0);
}`;

// Shapes of one field over its nodes, and their amplitudes, blended between instants.
class NodalField {
  constructor(data, block, nodes, components) {
    this.components = components;
    this.nodes = nodes;
    this.count = data ? data.shapes.shape[0] : 0;
    this.shapes = data ? arrayOf(block, data.shapes) : new Int16Array(0);
    this.series = data ? arrayOf(block, data.amplitudes) : new Float32Array(0);
    this.instants = data ? data.amplitudes.shape[1] : 0;
    this.now = new Float32Array(Math.max(1, this.count));
  }

  // Many shapes share a layer of the texture, because the number of layers is limited.
  textures() {
    const across = Math.min(1024, this.nodes),
      rows = Math.ceil(this.nodes / across);
    const perLayer = Math.max(1, Math.floor(2048 / rows)),
      channels = this.components === 3 ? 4 : 1;
    const layers = Math.max(1, Math.ceil(this.count / perLayer));
    const texels = new Int16Array(channels * across * rows * perLayer * layers);
    for (let k = 0; k < this.count; k++)
      for (let c = 0; c < this.components; c++)
        for (let i = 0, from = (k * this.components + c) * this.nodes; i < this.nodes; i++)
          texels[channels * (k * rows * across + i) + c] = this.shapes[from + i];
    const shapes = new DataArrayTexture(texels, across, rows * perLayer, layers);
    shapes.format = channels === 4 ? RGBAIntegerFormat : RedIntegerFormat;
    shapes.type = ShortType;
    shapes.unpackAlignment = 1;
    shapes.needsUpdate = true;
    this.texture = new DataTexture(this.now, this.now.length, 1, RedFormat, FloatType);
    this.texture.needsUpdate = true;
    return { shapes, across, rows, perLayer, amplitudes: this.texture };
  }

  blend({ before, after, share }) {
    for (let k = 0, row = 0; k < this.count; k++, row += this.instants)
      this.now[k] = this.series[row + before] * (1 - share) + this.series[row + after] * share;
    if (this.texture) this.texture.needsUpdate = true;
  }

  // Component c at a node, for the present amplitudes, or the amplitudes of a given time.
  at(node, c, instant = -1) {
    let sum = 0;
    for (let k = 0; k < this.count; k++)
      sum +=
        this.shapes[(k * this.components + c) * this.nodes + node] *
        (instant < 0 ? this.now[k] : this.series[k * this.instants + instant]);
    return sum;
  }

  // Components of all nodes at the present time.
  all() {
    const found = new Float32Array(this.components * this.nodes);
    for (let k = 0; k < this.count; k++) {
      const amplitude = this.now[k],
        from = k * found.length;
      for (let i = 0; i < found.length; i++) found[i] += amplitude * this.shapes[from + i];
    }
    return found;
  }
}

class Body {
  constructor(data, block) {
    Object.assign(this, { name: data.name, kind: data.kind, seenFrom: data.seenFrom });
    this.rest = arrayOf(block, data.nodes);
    this.number = data.nodes.shape[0];
    this.ids = arrayOf(block, data.ids);
    // Points of a beam's skin are attached to a node; a field may have no value at some of them.
    this.carriers = data.carriers && arrayOf(block, data.carriers);
    this.unknown = data.unknown && arrayOf(block, data.unknown);
    this.triangles = interleaved(arrayOf(block, data.triangles), 3);
    this.edges = interleaved(arrayOf(block, data.edges), 2);
    this.lifetimes = data.lifetimes && arrayOf(block, data.lifetimes);
    this.poses = arrayOf(block, data.pose);
    this.instants = data.pose.shape[1];
    this.deforms = data.displacement !== null;
    this.displacement = new NodalField(data.displacement, block, this.number, 3);
    this.fields = Object.fromEntries(
      Object.entries(data.fields).map(([name, each]) => [name, new NodalField(each, block, this.number, 1)]),
    );
    this.position = new Vector3();
    this.quaternion = new Quaternion();
  }

  // Sets position, rotation and amplitudes for a frame.
  moveTo(frame) {
    const pose = (row, at) => this.poses[row * this.instants + at];
    const blended = (row) => pose(row, frame.before) * (1 - frame.share) + pose(row, frame.after) * frame.share;
    this.position.set(blended(0), blended(1), blended(2));
    // At the wrap from the last time to the first the quaternion may change sign.
    const one = [3, 4, 5, 6].map((row) => pose(row, frame.before)),
      other = [3, 4, 5, 6].map((row) => pose(row, frame.after));
    const sign = one.reduce((sum, x, i) => sum + x * other[i], 0) < 0 ? -1 : 1;
    this.quaternion.set(...one.map((x, i) => x * (1 - frame.share) + sign * other[i] * frame.share)).normalize();
    this.displacement.blend(frame);
    Object.values(this.fields).forEach((field) => field.blend(frame));
    if (this.group) this.showAt(frame);
  }

  // Objects of the scene.
  build() {
    const geometry = new BufferGeometry();
    geometry.setAttribute("position", new BufferAttribute(this.rest, 3));
    if (this.unknown) geometry.setAttribute("unknown", new BufferAttribute(new Float32Array(this.unknown), 1));
    const textures = this.displacement.textures();
    this.fieldTextures = Object.fromEntries(
      Object.entries(this.fields).map(([name, field]) => [name, field.textures()]),
    );
    this.uniforms = {
      shapes: { value: textures.shapes },
      amplitudes: { value: textures.amplitudes },
      count: { value: this.displacement.count },
      fieldShapes: { value: textures.shapes },
      fieldAmplitudes: { value: textures.amplitudes },
      fieldCount: { value: -1 },
      across: { value: textures.across },
      rows: { value: textures.rows },
      perLayer: { value: textures.perLayer },
      gain: { value: 1 },
      ramp: { value: RAMP.map((each) => rgb(each)) },
      low: { value: 0 },
      high: { value: 1 },
    };
    const material = (own, settings = {}) =>
      new ShaderMaterial({
        glslVersion: GLSL3,
        vertexShader: MOVED,
        fragmentShader: SHADED,
        side: DoubleSide,
        ...settings,
        uniforms: {
          ...this.uniforms,
          plain: { value: rgb("#9aa5b1") },
          coloured: { value: false },
          lit: { value: false },
          ...own,
        },
      });
    this.faces = this.triangles.length
      ? new Mesh(
          geometry,
          material({ lit: { value: true } }, { polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 1 }),
        )
      : this.edges.length
        ? new LineSegments(geometry, material({}))
        : new Points(geometry, material({}));
    this.index = new BufferAttribute(new Uint32Array(this.triangles.length ? this.triangles : this.edges), 1);
    if (this.index.count) geometry.setIndex(this.index);
    const lines = geometry.clone();
    lines.setAttribute("position", geometry.getAttribute("position"));
    lines.setIndex(new BufferAttribute(new Uint32Array(this.edges), 1));
    this.outline = new LineSegments(lines, material({}));
    this.ghost = new LineSegments(lines, material({ gain: { value: 0 } }));
    // The undeformed outline is drawn first: without deflection the edges coincide with it and must be on top.
    this.ghost.renderOrder = -1;
    this.group = new Group();
    this.group.matrixAutoUpdate = false;
    for (const each of [this.faces, this.outline, this.ghost]) {
      each.frustumCulled = false;
      this.group.add(each);
    }
    this.alive = -1;
  }

  showAt({ before }) {
    this.group.matrix.compose(this.position, this.quaternion, new Vector3(1, 1, 1));
    this.group.matrixWorldNeedsUpdate = true;
    if (!this.lifetimes) return;
    const seen = this.trianglesAt(before);
    if (seen.length === this.alive) return;
    this.alive = seen.length;
    this.index.array.set(seen);
    this.index.needsUpdate = true;
    this.faces.geometry.setDrawRange(0, seen.length);
  }

  // Corners of the triangles that exist at a given time.
  trianglesAt(instant) {
    if (!this.lifetimes) return this.triangles;
    const number = this.triangles.length / 3,
      found = [];
    for (let i = 0; i < number; i++)
      if (this.lifetimes[i] <= instant && instant < this.lifetimes[number + i])
        found.push(this.triangles[3 * i], this.triangles[3 * i + 1], this.triangles[3 * i + 2]);
    return found;
  }

  // Colour by a field of the page's scales; a body without this field is plain.
  colourBy(name, scale) {
    const own = this.faces.material.uniforms,
      field = this.fieldTextures[name];
    own.coloured.value = Boolean(scale) && (name === "deflection" ? this.deforms : Boolean(field));
    this.uniforms.fieldCount.value = field ? this.fields[name].count : -1;
    if (field) {
      this.uniforms.fieldShapes.value = field.shapes;
      this.uniforms.fieldAmplitudes.value = field.amplitudes;
    }
    if (scale)
      [this.uniforms.low.value, this.uniforms.high.value] = [scale.low / scale.factor, scale.high / scale.factor];
    // Uniforms that materials share by value are copied into each of them.
    for (const each of [this.faces, this.outline, this.ghost])
      for (const key of ["fieldCount", "fieldShapes", "fieldAmplitudes", "low", "high"])
        each.material.uniforms[key].value = this.uniforms[key].value;
  }

  // The node to which a point of the surface is attached.
  carrierOf(point) {
    return this.carriers ? this.carriers[point] : point;
  }

  // Position of a node in the scene, with displacements enlarged.
  placeOf(node, gain) {
    const local = [0, 1, 2].map((c) => this.rest[3 * node + c] + gain * this.displacement.at(node, c));
    return new Vector3(...local).applyQuaternion(this.quaternion).add(this.position);
  }
}

const rgb = (colour) => {
  const number = parseInt(colour.slice(1), 16);
  return new Vector3((number >> 16) / 255, ((number >> 8) & 255) / 255, (number & 255) / 255);
};

// (c, n) as (n, c).
function interleaved(values, columns) {
  const number = values.length / columns,
    found = new Uint32Array(values.length);
  for (let c = 0; c < columns; c++) for (let i = 0; i < number; i++) found[columns * i + c] = values[c * number + i];
  return found;
}
