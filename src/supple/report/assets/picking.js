// The point of a body under the pointer: of the foremost triangle there, the corner nearest to the pointer.

function pointUnder(bodies, camera, root, frame, gain, x, y) {
  let best = null;
  const offer = (body, point, depth) => {
    if (!best || depth < best.depth) best = { body, point, depth };
  };
  for (const body of bodies) {
    if (!body.ids.length || !body.group.visible) continue;
    const screen = projected(body, camera, root, gain),
      triangles = body.trianglesAt(frame.before);
    for (let i = 0; i < triangles.length; i += 3) {
      const corners = [triangles[i], triangles[i + 1], triangles[i + 2]];
      const weights = weightsIn(screen, corners, x, y);
      if (!weights) continue;
      const depth = weights.reduce((sum, w, k) => sum + w * screen[3 * corners[k] + 2], 0);
      const nearest = [0, 1, 2].reduce((k, j) =>
        distance(screen, corners[j], x, y) < distance(screen, corners[k], x, y) ? j : k,
      );
      offer(body, corners[nearest], depth);
    }
    // For a body without faces, the nearest node within a few pixels.
    if (!triangles.length)
      for (let node = 0; node < body.number; node++)
        if (distance(screen, node, x, y) < 0.02) offer(body, node, screen[3 * node + 2]);
  }
  return best;
}

const distance = (screen, node, x, y) => Math.hypot(screen[3 * node] - x, screen[3 * node + 1] - y);

// All nodes of a body on the screen: x and y from -1 to 1, and the depth.
function projected(body, camera, root, gain) {
  const moved = body.displacement.all(),
    found = new Float32Array(3 * body.number),
    place = new Vector3();
  camera.updateMatrixWorld();
  for (let node = 0; node < body.number; node++) {
    place.set(...[0, 1, 2].map((c) => body.rest[3 * node + c] + gain * moved[c * body.number + node]));
    place.applyQuaternion(body.quaternion).add(body.position).applyMatrix4(root.matrix).project(camera);
    found.set([place.x, place.y, place.z], 3 * node);
  }
  return found;
}

// Barycentric coordinates of a point in a triangle, null outside.
function weightsIn(screen, [a, b, c], x, y) {
  const [ax, ay, bx, by, cx, cy] = [a, b, c].flatMap((node) => [screen[3 * node] - x, screen[3 * node + 1] - y]);
  const area = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax);
  // Points behind the camera are projected, too, beyond the depth of all visible points.
  if (!area || Math.max(screen[3 * a + 2], screen[3 * b + 2], screen[3 * c + 2]) > 1) return null;
  const weights = [(bx * cy - by * cx) / area, (cx * ay - cy * ax) / area, (ax * by - ay * bx) / area];
  return weights.every((w) => w >= 0) ? weights : null;
}
