// Marks: joints, springs, loads, contact forces, axes of joints. Their positions are computed here at each frame.

// Style of each kind of joint: shape, filled (1) or hollow (0), and the colour of a prescribed motion.
const JOINT_LOOKS = {
  fixed: [0, 1],
  ball: [1, 1],
  revolute: [1, 0],
  universal: [2, 0],
  cylindrical: [3, 0],
  prismatic: [0, 0],
  "prescribed rotation": [1, 0, "#d55e00"],
  "prescribed translation": [0, 0, "#d55e00"],
};
const GROUND_LOOK = [4, 0];

// Groups of marks, and the colours of arrows; lengths are relative to the largest of each kind.
const ARROWS = { loads: ["force", "moment"], contacts: ["contact"] };
const ARROW_COLOURS = { force: "#d55e00", moment: "#cc79a7", contact: "#e5484d" };

const POINT = `
in float look, filled;
in vec3 colour;
out float vLook, vFilled;
out vec3 vColour;
uniform float size;
void main() {
  vLook = look; vFilled = filled; vColour = colour;
  gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
  gl_PointSize = look > 3.5 ? 1.8 * size : size;
}`;

const MARK = `
precision highp float;
in float vLook, vFilled;
in vec3 vColour;
uniform vec3 page;
out vec4 colour;
void main() {
  vec2 p = 2.0 * gl_PointCoord - 1.0;
  float square = max(abs(p.x), abs(p.y)), disc = length(p), cross = min(abs(p.x - p.y), abs(p.x + p.y));
  float hexagon = max(abs(p.y), 0.866 * abs(p.x) + 0.5 * abs(p.y));
  float reach = vLook < 0.5 ? square : vLook < 1.5 ? disc : vLook < 2.5 ? square : vLook < 3.5 ? hexagon : square;
  if (reach > 0.95) discard;
  bool rim = reach > 0.66;
  if (vLook > 1.5 && vLook < 2.5) { rim = cross < 0.35; if (!rim) discard; }
  if (vLook > 3.5) { rim = mod(4.0 * (p.x + p.y), 2.0) < 0.6 || reach > 0.85; if (!rim) discard; }
  colour = vec4(rim || vFilled > 0.5 ? vColour : page, 1.0);
}`;

// A point that moves with a body, or is fixed to the ground.
class Place {
  constructor(data, block, bodies) {
    this.body = bodies[data.body];
    this.rest = data.rest;
    this.moved = series(block, data.moved);
    this.turned = series(block, data.turned);
  }

  at(frame, gain) {
    const moved = this.moved(frame);
    const point = new Vector3(...this.rest.map((x, i) => x + (this.body ? gain : 1) * moved[i]));
    const turned = new Quaternion(...this.turned(frame)).normalize();
    if (!this.body) return { point, turned };
    return {
      point: point.applyQuaternion(this.body.quaternion).add(this.body.position),
      turned: turned.premultiply(this.body.quaternion),
    };
  }
}

// Columns (c, t) as a function of the frame; a single time is constant.
function series(block, packing) {
  const values = arrayOf(block, packing),
    [columns, instants] = packing.shape;
  return ({ before, after, share }) => {
    const [a, b] = instants === 1 ? [0, 0] : [before, after];
    return Array.from(
      { length: columns },
      (_, c) => values[c * instants + a] * (1 - share) + values[c * instants + b] * share,
    );
  };
}

class Marks {
  constructor(scene, block, bodies, extent) {
    const placed = (each) => ({
      ...each,
      first: new Place(each.first, block, bodies),
      second: new Place(each.second, block, bodies),
    });
    this.extent = extent;
    this.arrowLength = scene.arrowLength;
    this.joints = scene.joints.map(placed);
    this.links = scene.links.map(placed);
    this.arrows = scene.arrows.map((each) => ({
      ...each,
      place: new Place(each.place, block, bodies),
      values: series(block, each.values),
    }));
    this.largest = { force: 0, moment: 0, contact: 0 };
    for (const arrow of this.arrows) this.largest[arrow.kind] = Math.max(this.largest[arrow.kind], arrow.largest);
    this.picked = null;
  }

  build() {
    // Two points per joint, and one for the selected node.
    this.points = pointCloud(2 * this.joints.length + 1);
    this.lines = {
      links: lineSet(this.links.length),
      triads: lineSet(3 * this.joints.length),
      loads: lineSet(5 * this.arrows.length),
    };
    this.group = new Group();
    this.group.add(this.points, ...Object.values(this.lines));
  }

  moveTo(frame, gain, shown, ink, paper) {
    const points = [],
      triads = [],
      links = [],
      loads = [];
    this.points.material.uniforms.page.value = rgb(paper);
    const heldPoints = shown.joints ? this.joints : [];
    for (const joint of heldPoints) {
      const look = JOINT_LOOKS[joint.kind] || [2, 0];
      if (!joint.first.body) points.push([joint.first.at(frame, gain).point, GROUND_LOOK, "#8a8a8a"]);
      points.push([(joint.second.body ? joint.second : joint.first).at(frame, gain).point, look, look[2] || ink]);
    }
    if (this.picked) points.push([this.picked(), [1, 1], "#d55e00"]);
    fillPoints(this.points, points);
    if (shown.triads)
      for (const joint of this.joints) {
        const { point, turned } = joint.second.at(frame, gain);
        ["#d03030", "#2f9e44", "#3060d0"].forEach((colour, i) => {
          const axis = new Vector3(...[0, 1, 2].map((c) => (c === i ? 0.07 * this.extent : 0)));
          triads.push([point, axis.applyQuaternion(turned).add(point), colour]);
        });
      }
    for (const link of this.links)
      links.push([link.first.at(frame, gain).point, link.second.at(frame, gain).point, "#009e73"]);
    for (const [name, kinds] of Object.entries(ARROWS))
      if (shown[name])
        for (const arrow of this.arrows) if (kinds.includes(arrow.kind)) this.addArrow(loads, arrow, frame, gain);
    fillLines(this.lines.triads, triads);
    fillLines(this.lines.links, links);
    fillLines(this.lines.loads, loads);
  }

  // An arrow with its head at the point, of length relative to the largest; a moment has two heads.
  addArrow(lines, arrow, frame, gain) {
    const value = new Vector3(...arrow.values(frame)),
      size = value.length(),
      colour = ARROW_COLOURS[arrow.kind];
    if (!(size > 1e-6 * this.largest[arrow.kind])) return;
    const tip = arrow.place.at(frame, gain).point,
      length = this.arrowLength * (size / this.largest[arrow.kind]);
    const along = value.divideScalar(size),
      tail = tip.clone().addScaledVector(along, -length);
    const across = new Vector3(along.y, along.z, along.x)
      .cross(along)
      .normalize()
      .multiplyScalar(0.01 * this.extent);
    lines.push([tail, tip, colour]);
    for (const head of arrow.kind === "moment" ? [0, 0.03] : [0]) {
      const end = tip.clone().addScaledVector(along, -head * this.extent),
        foot = end.clone().addScaledVector(along, -0.03 * this.extent);
      lines.push([end, foot.clone().add(across), colour], [end, foot.sub(across), colour]);
    }
  }
}

function pointCloud(most) {
  const geometry = new BufferGeometry();
  for (const [name, size] of [
    ["position", 3],
    ["look", 1],
    ["filled", 1],
    ["colour", 3],
  ])
    geometry.setAttribute(name, new BufferAttribute(new Float32Array(size * most), size));
  const points = new Points(
    geometry,
    new ShaderMaterial({
      glslVersion: GLSL3,
      vertexShader: POINT,
      fragmentShader: MARK,
      depthTest: false,
      depthWrite: false,
      transparent: true,
      uniforms: { page: { value: rgb("#ffffff") }, size: { value: 12 * (window.devicePixelRatio || 1) } },
    }),
  );
  points.frustumCulled = false;
  points.renderOrder = 2;
  return points;
}

function fillPoints(points, list) {
  const { position, look, filled, colour } = points.geometry.attributes;
  list.forEach(([place, [shape, full], own], i) => {
    position.setXYZ(i, place.x, place.y, place.z);
    look.setX(i, shape);
    filled.setX(i, full);
    const { x, y, z } = rgb(own);
    colour.setXYZ(i, x, y, z);
  });
  for (const each of [position, look, filled, colour]) each.needsUpdate = true;
  points.geometry.setDrawRange(0, list.length);
}

const LINE =
  "in vec3 colour; out vec3 vColour; void main() { vColour = colour; gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0); }";
const LINE_COLOUR =
  "precision highp float; in vec3 vColour; out vec4 colour; void main() { colour = vec4(vColour, 1.0); }";

function lineSet(most) {
  const geometry = new BufferGeometry();
  for (const name of ["position", "colour"])
    geometry.setAttribute(name, new BufferAttribute(new Float32Array(6 * most), 3));
  const lines = new LineSegments(
    geometry,
    new ShaderMaterial({
      glslVersion: GLSL3,
      vertexShader: LINE,
      fragmentShader: LINE_COLOUR,
      depthTest: false,
      transparent: true,
    }),
  );
  lines.frustumCulled = false;
  lines.renderOrder = 1;
  return lines;
}

function fillLines(lines, list) {
  const { position, colour } = lines.geometry.attributes;
  list.forEach(([from, to, own], i) => {
    const { x, y, z } = rgb(own);
    position.setXYZ(2 * i, from.x, from.y, from.z);
    position.setXYZ(2 * i + 1, to.x, to.y, to.z);
    colour.setXYZ(2 * i, x, y, z);
    colour.setXYZ(2 * i + 1, x, y, z);
  });
  position.needsUpdate = colour.needsUpdate = true;
  lines.geometry.setDrawRange(0, 2 * list.length);
}
