// Robot and floor: frames as nested groups, with shapes in them.

const STYLES = ["solid", "translucent", "wireframe", "hidden"];

class Shapes {
  constructor(replay) {
    this.root = new THREE.Group();
    this.groups = new Map([[replay.world, this.root]]);
    this.frames = replay.frames;
    for (const frame of this.frames) this.groups.set(frame.name, new THREE.Group());
    for (const frame of this.frames) this.groups.get(frame.parent).add(this.groups.get(frame.name));
    // The root frame of the robot.
    this.base = this.frames.find((f) => f.parent === replay.world)?.name ?? replay.world;
    this.robot = [];
    for (const shape of replay.shapes) {
      const object = meshOf(shape);
      setPose(object, shape.pose, 0);
      this.groups.get(shape.frame).add(object);
      if (shape.frame !== replay.world) this.robot.push({ object, frame: shape.frame, opacity: shape.colour[3] });
    }
    for (const frame of this.frames) if (frame.fixed) setPose(this.groups.get(frame.name), frame.poses, 0);
    this.show(0);
  }

  show(tick) {
    for (const frame of this.frames) if (!frame.fixed) setPose(this.groups.get(frame.name), frame.poses, 7 * tick);
    this.root.updateMatrixWorld(true);
  }

  style(name) {
    for (const { object, opacity } of this.robot) {
      const material = object.material;
      object.visible = name !== "hidden";
      material.wireframe = name === "wireframe";
      material.opacity = name === "translucent" ? 0.35 * opacity : opacity;
      material.transparent = material.opacity < 1;
      material.depthWrite = !material.transparent;
      material.needsUpdate = true;
    }
  }

  // Position of a frame in the world.
  at(name) {
    return new THREE.Vector3().setFromMatrixPosition(this.groups.get(name).matrixWorld);
  }

  // The point that the camera follows: the base, or the middle of all that moves if the robot has no shape.
  followed() {
    const isObject = ({ frame }) => frame.startsWith("object/");
    return this.robot.length > 0 && this.robot.every(isObject) ? this.bounds().middle : this.at(this.base);
  }

  // Centre and half diagonal of robot and objects at the shown tick.
  bounds() {
    const [low, high] = [new THREE.Vector3().setScalar(Infinity), new THREE.Vector3().setScalar(-Infinity)];
    const take = (centre, radius) => {
      low.min(centre.clone().subScalar(radius));
      high.max(centre.clone().addScalar(radius));
    };
    for (const { object } of this.robot) {
      const { centre, radius } = sphereOf(object);
      take(centre, 0.7 * radius);
    }
    for (const frame of this.frames) take(this.at(frame.name), 0.01);
    return { middle: low.clone().add(high).multiplyScalar(0.5), extent: Math.max(0.05, 0.5 * high.distanceTo(low)) };
  }
}

// Bounding sphere of a body, in the world.
function sphereOf(object) {
  const { geometry, scale } = object;
  if (!geometry.boundingSphere) geometry.computeBoundingSphere();
  const { center, radius } = geometry.boundingSphere;
  // Bodies of unit size are scaled; the half diagonal of the scaled one is at most that of its box.
  const reach = scale.x === scale.y && scale.y === scale.z ? radius * scale.x : 0.5 * scale.length();
  return { centre: center.clone().applyMatrix4(object.matrixWorld), radius: reach };
}

// Sets position and quaternion from seven numbers.
function setPose(object, numbers, from) {
  object.position.set(numbers[from], numbers[from + 1], numbers[from + 2]);
  object.quaternion.set(numbers[from + 3], numbers[from + 4], numbers[from + 5], numbers[from + 6]).normalize();
}

function meshOf(shape) {
  const [red, green, blue, opacity] = shape.colour;
  const color = new THREE.Color().setRGB(red, green, blue, "srgb");
  if (shape.kind === "lines") {
    const material = new THREE.LineBasicMaterial({ color, opacity, transparent: opacity < 1 });
    const Kind = { pairs: THREE.LineSegments, loop: THREE.LineLoop, strip: THREE.Line }[shape.line];
    return new Kind(geometryOf(shape.points), material);
  }
  const floor = shape.entity.startsWith("floor");
  const material = new THREE.MeshLambertMaterial({
    color,
    opacity,
    transparent: opacity < 1,
    flatShading: shape.kind === "mesh",
    side: THREE.DoubleSide,
    // Grid and contacts lie in the floor's face; the offset draws them on top of it.
    polygonOffset: floor,
    polygonOffsetFactor: 1,
    polygonOffsetUnits: 1,
  });
  const mesh = new THREE.Mesh(solid(shape), material);
  if (shape.size) mesh.scale.set(...shape.size);
  return mesh;
}

// A body of unit size, to be scaled.
function solid(shape) {
  switch (shape.kind) {
    case "box":
      return new THREE.BoxGeometry(1, 1, 1);
    case "sphere":
      return new THREE.SphereGeometry(0.5, 32, 20);
    case "cylinder":
      // Along y in three.js, along z in the log.
      return new THREE.CylinderGeometry(0.5 * shape.ends[1], 0.5 * shape.ends[0], 1, 32).rotateX(Math.PI / 2);
    default:
      return geometryOf(shape.points, shape.indices);
  }
}

function geometryOf(points, indices) {
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", new THREE.BufferAttribute(points, 3));
  if (indices && indices.length > 0) geometry.setIndex(new THREE.BufferAttribute(indices, 1));
  if (indices) geometry.computeVertexNormals();
  return geometry;
}
