// The view: renderer, camera, the axes in the corner.

class View {
  constructor(canvas, scene, changed) {
    this.canvas = canvas;
    this.renderer = new WebGLRenderer({ canvas, antialias: true, alpha: true });
    this.scene = new Scene();
    this.root = new Group();
    this.root.matrixAutoUpdate = false;
    this.scene.add(this.root);
    this.radius = Math.hypot(...scene.half) || 1;
    this.half = new Vector3(...scene.half);
    this.up = new Vector3(...scene.up);
    this.camera = new PerspectiveCamera(30, 1, 0.01 * this.radius, 40 * this.radius);
    this.camera.up.copy(this.up);
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.enableDamping = false;
    this.controls.addEventListener("change", changed);
    this.controls.addEventListener("start", () => (this.looksBy = null));
    new ResizeObserver(changed).observe(canvas);
    this.look("fit");
  }

  // Default view: the widest motion from left to right, slightly from the side and above; or along an axis.
  look(which) {
    this.looksBy = which;
    const from = new Vector3();
    if (which === "fit") {
      const level = [0, 1, 2].filter((i) => Math.abs(this.up.getComponent(i)) < 0.8);
      const [thin, wide] = level
        .sort((i, j) => this.half.getComponent(i) - this.half.getComponent(j))
        .map((i) => new Vector3().setComponent(i, 1));
      const side = new Vector3().crossVectors(this.up, thin).dot(wide) < 0 ? -1 : 1;
      from.addScaledVector(thin, side).addScaledVector(wide, 0.4).addScaledVector(this.up, 0.28);
    } else {
      from.setComponent("xyz".indexOf(which[1]), which[0] === "-" ? -1 : 1);
      // Exactly from above, the upward direction is undefined; a slight offset avoids this.
      if (Math.abs(from.dot(this.up)) > 0.99) from.add(new Vector3(1e-4, 2e-4, 3e-4));
    }
    this.controls.target.set(0, 0, 0);
    this.camera.position.copy(from.normalize());
    this.camera.lookAt(0, 0, 0);
    this.camera.position.multiplyScalar(this.distance());
    this.controls.update();
  }

  // Distance from the centre at which all corners of the motion's extent are in the picture, with a margin.
  distance() {
    const upright = Math.tan((this.camera.fov * Math.PI) / 360) / 1.12,
      level = upright * this.camera.aspect,
      seen = this.camera.quaternion.clone().invert();
    let farthest = 0;
    for (let corner = 0; corner < 8; corner++) {
      const at = new Vector3(
        ...[0, 1, 2].map((i) => (corner & (1 << i) ? 1 : -1) * this.half.getComponent(i)),
      ).applyQuaternion(seen);
      farthest = Math.max(farthest, at.z + Math.abs(at.x) / level, at.z + Math.abs(at.y) / upright);
    }
    return farthest || 1;
  }

  // The body that stays fixed in the view, while everything else moves relative to it; null: the ground.
  follow(body, still) {
    this.root.matrix.identity();
    if (body)
      this.root.matrix
        .compose(body.position, body.quaternion, new Vector3(1, 1, 1))
        .invert()
        .premultiply(still);
    this.root.matrixWorldNeedsUpdate = true;
  }

  resize() {
    const { clientWidth: width, clientHeight: height } = this.canvas;
    if (!width || !height) return;
    this.renderer.setPixelRatio(window.devicePixelRatio || 1);
    this.renderer.setSize(width, height, false);
    if (this.camera.aspect === width / height) return;
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    // Until the user rotates the view, everything remains in the picture.
    if (this.looksBy) this.look(this.looksBy);
  }

  draw() {
    this.resize();
    this.renderer.render(this.scene, this.camera);
    this.drawAxes();
  }

  drawAxes() {
    const canvas = document.getElementById("axes"),
      pen = canvas.getContext("2d"),
      middle = canvas.width / 2;
    pen.clearRect(0, 0, canvas.width, canvas.height);
    pen.font = "22px system-ui, sans-serif";
    pen.textAlign = "center";
    pen.textBaseline = "middle";
    pen.lineWidth = 3;
    const seen = this.camera.quaternion.clone().invert(),
      turned = new Quaternion().setFromRotationMatrix(this.root.matrix);
    ["x", "y", "z"].forEach((name, i) => {
      const axis = new Vector3().setComponent(i, 1).applyQuaternion(turned).applyQuaternion(seen);
      pen.strokeStyle = pen.fillStyle = ["#d03030", "#2f9e44", isDark() ? "#7aa2ff" : "#3060d0"][i];
      pen.beginPath();
      pen.moveTo(middle, middle);
      pen.lineTo(middle + 50 * axis.x, middle - 50 * axis.y);
      pen.stroke();
      pen.fillText(name, middle + 66 * axis.x, middle - 66 * axis.y);
    });
  }
}
