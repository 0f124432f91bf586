// The robot's own view: a camera on a frame of the robot, drawn in a corner of the canvas.

class RobotCamera {
  constructor(shapes, marks, extent, box) {
    this.shapes = shapes;
    this.marks = marks;
    this.box = box;
    this.camera = new THREE.PerspectiveCamera(60, 4 / 3, 0.002 * extent, 100 * Math.max(extent, 1));
    this.on = true;
    this.frames = shapes.frames.map((f) => f.name).filter((name) => !name.startsWith("sole/"));
    // The default is the highest frame, usually the head; of equally high frames the one nearest to the base.
    const toBase = shapes.groups.get(shapes.base).matrixWorld.clone().invert();
    const height = (name) => shapes.at(name).applyMatrix4(toBase).z;
    const higher = (best, name) => (height(name) > height(best) + 1e-6 ? name : best);
    this.choose(this.frames.reduce(higher, shapes.base));
  }

  // Mounts the camera on a frame. It looks along the frame's axis that is nearest to the base's x axis (forward) at the
  // first tick; the axis nearest to z is up.
  choose(name) {
    this.frame = name;
    this.shapes.show(0);
    const inverse = this.shapes.groups.get(name).matrixWorld.clone().invert();
    const base = this.shapes.groups.get(this.shapes.base).matrixWorld;
    const turn = inverse.multiply(base);
    const along = (x, y, z) => nearestAxis(new THREE.Vector3(x, y, z).transformDirection(turn));
    const [forward, up] = [along(1, 0, 0), along(0, 0, 1)];
    const right = forward.clone().cross(up);
    // Cameras of three.js look along -z with y up.
    this.turn = new THREE.Quaternion().setFromRotationMatrix(new THREE.Matrix4().makeBasis(right, up, forward.negate()));
  }

  draw(renderer, scene) {
    if (!this.on) return;
    const { left, top, width, height } = this.box.getBoundingClientRect();
    const canvas = renderer.domElement.getBoundingClientRect();
    if (width === 0) return;
    const group = this.shapes.groups.get(this.frame);
    group.matrixWorld.decompose(this.camera.position, this.camera.quaternion, new THREE.Vector3());
    this.camera.quaternion.multiply(this.turn);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    // Parts that enclose the camera do not hide its view, and markers are not visible to a robot.
    const inside = this.shapes.robot.filter((part) => encloses(part.object, this.camera.position));
    const frames = new Set([this.frame, ...inside.map((part) => part.frame)]);
    const own = this.shapes.robot.filter((part) => part.object.visible && frames.has(part.frame)).map((part) => part.object);
    const hidden = [...own, this.marks.root];
    hidden.forEach((object) => (object.visible = false));
    const [x, y] = [left - canvas.left, canvas.bottom - top - height];
    renderer.setScissorTest(true);
    renderer.setScissor(x, y, width, height);
    renderer.setViewport(x, y, width, height);
    renderer.render(scene, this.camera);
    renderer.setScissorTest(false);
    hidden.forEach((object) => (object.visible = true));
  }
}

function nearestAxis(v) {
  const sizes = [Math.abs(v.x), Math.abs(v.y), Math.abs(v.z)];
  const axis = sizes.indexOf(Math.max(...sizes));
  const found = new THREE.Vector3();
  found.setComponent(axis, Math.sign(v.getComponent(axis)));
  return found;
}

// True if a point is within the bounding sphere of a body.
function encloses(object, point) {
  const { centre, radius } = sphereOf(object);
  return centre.distanceTo(point) < radius;
}
