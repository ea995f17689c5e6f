// The player: clip, time and display settings.

const SPEEDS = [0.1, 0.25, 0.5, 1, 2, 5];
const SECONDS = [2, 5, 10, 20, 60];

class Player {
  constructor(scene, block, curves) {
    this.scene = scene;
    this.curves = curves;
    this.times = arrayOf(block, scene.times);
    this.clips = head.clips.length
      ? head.clips
      : [{ name: "", first: 0, number: this.times.length, note: "", repeats: false }];
    this.bodies = scene.bodies.map((data) => new Body(data, block));
    this.marks = new Marks(scene, block, this.bodies, 2 * Math.hypot(...scene.half) || 1);
    this.obstacles = scene.obstacles.map((data) => ({
      points: arrayOf(block, data.points),
      triangles: interleaved(arrayOf(block, data.triangles), 3),
      offset: series(block, data.offsets),
    }));
    Object.assign(this, {
      playing: false,
      gain: 1,
      field: "",
      followed: null,
      picked: null,
      rate: 1,
      time: 0,
      dirty: true,
    });
    this.shown = { undeformed: true, edges: true, joints: true, triads: false, loads: true, contacts: true };
  }

  // Throws an error without WebGL.
  build() {
    this.view = new View(document.getElementById("view"), this.scene, () => (this.dirty = true));
    for (const body of this.bodies) {
      body.build();
      this.view.root.add(body.group);
    }
    this.walls = this.obstacles.map(({ points, triangles }) => {
      const geometry = new BufferGeometry();
      geometry.setAttribute("position", new BufferAttribute(points, 3));
      geometry.setIndex(new BufferAttribute(triangles, 1));
      // A wall is drawn behind nodes that penetrate it (penalty contact).
      const wall = new Mesh(
        geometry,
        new ShaderMaterial({
          glslVersion: GLSL3,
          side: DoubleSide,
          polygonOffset: true,
          polygonOffsetFactor: 4,
          polygonOffsetUnits: 40,
          vertexShader:
            "out vec3 seen; void main() { vec4 at = modelViewMatrix * vec4(position, 1.0); seen = at.xyz; gl_Position = projectionMatrix * at; }",
          fragmentShader:
            "precision highp float; in vec3 seen; uniform vec3 plain; out vec4 colour; void main() { vec3 n = normalize(cross(dFdx(seen), dFdy(seen))); colour = vec4(plain * (0.7 + 0.3 * abs(dot(n, normalize(seen)))), 1.0); }",
          uniforms: { plain: { value: rgb("#b9a58a") } },
        }),
      );
      this.view.root.add(wall);
      return wall;
    });
    this.marks.build();
    this.view.root.add(this.marks.group);
    this.choose(0);
    this.colour(Object.keys(this.scene.scales)[0] || "");
    const loop = (now) => {
      this.step(now);
      requestAnimationFrame(loop);
    };
    requestAnimationFrame(loop);
  }

  get clip() {
    return this.clips[this.number];
  }
  // Time of a row of the clip, from the start of the clip.
  timeOf(row) {
    return this.times[this.clip.first + row] - this.times[this.clip.first];
  }
  // In a periodic motion the last time is followed by the first.
  get length() {
    const { number, repeats } = this.clip,
      last = this.timeOf(number - 1);
    return repeats && number > 1 ? (last * number) / (number - 1) : last;
  }

  choose(number) {
    this.number = number;
    this.time = 0;
    this.rate = this.clip.repeats ? this.length / 2 : this.rate;
    this.still = null;
    this.seek(0);
  }

  // Time from the start of the clip.
  seek(time) {
    this.time = Math.min(Math.max(time, 0), this.length);
    this.dirty = true;
    this.place();
  }

  seekRow(row) {
    this.seek(this.timeOf(Math.min(Math.max(row, 0), this.clip.number - 1)));
  }
  get row() {
    return Math.round(this.frame.before - this.clip.first + this.frame.share);
  }

  step(now) {
    const passed = Math.min(0.1, (now - (this.last ?? now)) / 1000);
    this.last = now;
    if (this.playing && this.length > 0) {
      let time = this.time + passed * this.rate;
      if (time >= this.length) {
        if (this.looping) time %= this.length;
        else this.play(false);
      }
      this.seek(time);
    }
    if (this.dirty) this.draw();
  }

  play(on = !this.playing) {
    if (on && this.time >= this.length) this.time = 0;
    this.playing = on && this.length > 0;
    this.onplay?.();
  }

  // Rows before and after the time, and its fraction between them.
  place() {
    const { first, number, repeats } = this.clip;
    let low = 0,
      high = number - 1;
    while (high - low > 1) {
      const middle = (low + high) >> 1;
      if (this.timeOf(middle) <= this.time) low = middle;
      else high = middle;
    }
    if (this.time >= this.timeOf(high)) low = high;
    const next = low < number - 1 ? low + 1 : repeats ? 0 : low;
    const span = (low < number - 1 ? this.timeOf(next) : this.length) - this.timeOf(low);
    this.frame = {
      before: first + low,
      after: first + next,
      share: span > 0 ? Math.min(1, (this.time - this.timeOf(low)) / span) : 0,
    };
    for (const body of this.bodies) body.moveTo(this.frame);
    this.curves.showTime(this.scene.start + this.times[first] + this.time);
    this.ontime?.();
  }

  colour(name) {
    this.field = name;
    const scale = this.scene.scales[name];
    for (const body of this.bodies) body.colourBy(name, scale);
    drawLegend(scale);
    this.dirty = true;
  }

  follow(number) {
    this.followed = this.bodies[number] || null;
    this.still = null;
    this.dirty = true;
  }

  draw() {
    this.dirty = false;
    if (!this.view) return;
    const ink = isDark() ? "#e6e8eb" : "#1b1f24",
      paper = isDark() ? "#1d2125" : "#ffffff";
    for (const body of this.bodies) {
      for (const each of [body.faces, body.outline]) each.material.uniforms.gain.value = this.gain;
      body.outline.visible = this.shown.edges && !body.lifetimes;
      body.ghost.visible = this.shown.undeformed && body.deforms;
      body.outline.material.uniforms.plain.value = rgb(isDark() ? "#8a939c" : "#30363d");
      body.ghost.material.uniforms.plain.value = rgb(isDark() ? "#59616a" : "#9aa1a8");
    }
    if (this.followed && !this.still) {
      this.still = this.view.root.matrix
        .clone()
        .compose(this.followed.position, this.followed.quaternion, new Vector3(1, 1, 1));
    }
    this.view.follow(this.followed, this.still);
    this.walls.forEach((wall, i) => wall.position.set(...this.obstacles[i].offset(this.frame)));
    this.marks.moveTo(this.frame, this.gain, this.shown, ink, paper);
    this.view.draw();
  }

  // The node under a point of the canvas, in pixels from its corner; null outside the machine.
  pick(x, y) {
    const { clientWidth, clientHeight } = this.view.canvas;
    const found = pointUnder(
      this.bodies,
      this.view.camera,
      this.view.root,
      this.frame,
      this.gain,
      (2 * x) / clientWidth - 1,
      1 - (2 * y) / clientHeight,
    );
    this.picked = found && { ...found, node: found.body.carrierOf(found.point) };
    this.marks.picked = found && (() => found.body.placeOf(this.picked.node, this.gain));
    this.dirty = true;
    this.onpick?.();
    return this.reading();
  }

  // Data of the selected node at the present time.
  reading() {
    if (!this.picked) return null;
    const { body, node, point } = this.picked;
    const displacement = [0, 1, 2].map((c) => body.displacement.at(node, c)),
      place = body.placeOf(node, 1);
    const fields = Object.fromEntries(
      (body.unknown?.[point] ? [] : Object.keys(body.fields)).map((name) => [name, this.valueAt(body, name, point)]),
    );
    if (body.deforms) fields.deflection = this.scene.scales.deflection.factor * Math.hypot(...displacement);
    return {
      body: body.name,
      node: body.ids[node],
      displacement,
      fields,
      seenFrom: body.seenFrom,
      position: [place.x, place.y, place.z].map((x, i) => x + this.scene.middle[i]),
    };
  }

  // Value of a field, at present or at a given time, not below the scale: omitted shapes can cause such values.
  valueAt(body, name, point, instant) {
    const { factor, low } = this.scene.scales[name];
    return Math.max(low, factor * body.fields[name].at(point, 0, instant));
  }

  // Chart of the colour field at the selected node over the clip, or of the displacements without such a field.
  history() {
    if (!this.picked) return null;
    const { body, node, point } = this.picked,
      { first, number } = this.clip,
      rows = Array.from({ length: number }, (_, i) => first + i);
    const abscissa = rows.map((row) => this.scene.start + this.times[row]);
    const scale = this.scene.scales[this.field];
    const title = `node ${body.ids[node]} of ${body.name}`;
    if (body.fields[this.field] && !body.unknown?.[point])
      return {
        title: `${title}, ${this.field}`,
        label: scale.label,
        note: `values \u00b1 ${shownNumber(scale.error, 2)}`,
        over: "",
        abscissa,
        names: [this.field],
        columns: [rows.map((row) => this.valueAt(body, this.field, point, row))],
      };
    const columns = [0, 1, 2].map((c) => rows.map((row) => body.displacement.at(node, c, row)));
    return {
      title: `${title}, deflection`,
      label: head.length ? `deflection (${head.length})` : "deflection",
      over: "",
      abscissa,
      note: `seen from ${body.seenFrom}`,
      names: ["x", "y", "z", "magnitude"],
      columns: [...columns, rows.map((_, i) => Math.hypot(...columns.map((own) => own[i])))],
    };
  }
}
