// Markers of invisible quantities: contact states, forces, balance, points of interest.

// Sticking is green, sliding orange; smaller patterns are paler.
const STATES = {
  "face-static": 0x12813f,
  "edge-static": 0x4fb36a,
  "vertex-static": 0xa5d98f,
  "face-dynamic": 0xc2410c,
  "edge-dynamic": 0xf0892b,
  "vertex-dynamic": 0xfcc77d,
  free: 0x8a8f98,
};
const COLOURS = {
  external: 0xd6202c,
  com: 0xe0b400,
  path: 0x1fa34a,
  cop: 0xa81fa8,
  stable: 0x12a5b8,
  polygon: 0x1f5fd6,
  point: 0x111111,
};
// Colours of the nearest bodies: beyond the margin, within it, overlapping.
const NEARNESS = { apart: 0x1f5fd6, near: 0xf0892b, overlap: 0xd6202c };

// `edge-1-static` is of kind `edge-static`.
function kindOf(state) {
  const parts = state.split("-");
  const kind = parts.length > 1 ? `${parts[0]}-${parts[parts.length - 1]}` : state;
  return kind in STATES ? kind : "free";
}

class Markers {
  constructor(replay, extent) {
    this.replay = replay;
    this.root = new THREE.Group();
    this.size = markerSize(replay, extent);
    this.scale = 1;
    this.metresPerNewton = extent / usualForce(replay);
    this.layers = {};
    const layer = (name, known, build) => {
      if (!known) return;
      const group = new THREE.Group();
      this.root.add(group);
      this.layers[name] = { group, show: build(group) };
    };
    layer("states", replay.soles?.length, (group) => this.soles(group));
    layer("forces", replay.soles?.length, (group) => this.forces(group));
    layer("resultants", replay.soles?.length, (group) => this.resultants(group));
    layer("external", replay.external?.numbers.length, (group) => this.external(group));
    // A robot without mass has no centre of mass.
    const com = replay.com && !Number.isNaN(replay.com[0]);
    layer("com", com, (group) => this.ball(group, replay.com, COLOURS.com, 2));
    layer("path", com, (group) => this.path(group));
    layer("cop", replay.cop, (group) => this.ball(group, replay.cop, COLOURS.cop, 1.5));
    layer("polygon", replay.polygon, (group) => this.polygon(group));
    layer("stable", replay.stable, (group) => this.ball(group, replay.stable, COLOURS.stable, 1.5));
    layer("nearest", replay.nearest, (group) => this.nearest(group));
    layer("points", replay.points.length, (group) => this.points(group));
    this.through(true);
  }

  show(tick) {
    for (const { show } of Object.values(this.layers)) show(tick);
  }

  toggle(name, on) {
    this.layers[name].group.visible = on;
  }

  // Sets whether markers are visible through the robot.
  through(on) {
    this.isThrough = on;
    this.root.traverse((object) => {
      if (!object.material) return;
      object.material.depthTest = !on;
      object.renderOrder = 10;
    });
  }

  ball(group, column, colour, times) {
    const mesh = new THREE.Mesh(new THREE.SphereGeometry(0.5, 24, 16), lit(colour));
    mesh.scale.setScalar(times * this.size);
    group.add(mesh);
    return (tick) => {
      const at = vectorAt(column, tick);
      mesh.visible = at !== null;
      if (at) mesh.position.copy(at);
    };
  }

  soles(group) {
    const shows = this.replay.soles.map((sole) => {
      if (sole.points) return this.changing(group, sole);
      const k = sole.vertices.length;
      const corners = new Float32Array(3 * k);
      const fan = [];
      for (let i = 1; i + 1 < k; i++) fan.push(0, i, i + 1);
      const fill = new THREE.Mesh(geometryOf(corners, new Uint32Array(fan)), flat(0, 0.55));
      const outline = new THREE.LineLoop(geometryOf(corners), new THREE.LineBasicMaterial({ transparent: true }));
      const balls = sole.vertices.map(() => new THREE.Mesh(new THREE.SphereGeometry(0.5, 16, 12), lit(0)));
      balls.forEach((ball) => ball.scale.setScalar(this.size));
      fill.frustumCulled = outline.frustumCulled = false;
      group.add(fill, outline, ...balls);
      return (tick) => {
        const colour = STATES[kindOf(sole.states[sole.state[tick]])];
        sole.vertices.forEach((vertex, i) => {
          const at = vertex.position.subarray(3 * tick, 3 * tick + 3);
          corners.set(at, 3 * i);
          balls[i].position.set(...at);
          balls[i].visible = vertex.clamped[tick] === 1;
          balls[i].material.color.setHex(colour);
        });
        for (const part of [fill, outline]) {
          part.geometry.attributes.position.needsUpdate = true;
          part.material.color.setHex(colour);
        }
      };
    });
    return (tick) => shows.forEach((show) => show(tick));
  }

  // A contact whose vertices change: the polygon of those at a tick, and balls at the clamped ones.
  changing(group, sole) {
    const outline = new THREE.LineLoop(new THREE.BufferGeometry(), new THREE.LineBasicMaterial({ transparent: true }));
    const fill = new THREE.Mesh(new THREE.BufferGeometry(), flat(0, 0.55));
    outline.frustumCulled = fill.frustumCulled = false;
    group.add(fill, outline);
    const balls = [];
    return (tick) => {
      const colour = STATES[kindOf(sole.states[sole.state[tick]])];
      const points = contactsAt(sole, tick);
      setPolygon(outline, fill, new Float32Array(points.flatMap(({ at }) => at.toArray())));
      for (const part of [outline, fill]) part.material.color.setHex(colour);
      while (balls.length < points.length) {
        const ball = new THREE.Mesh(new THREE.SphereGeometry(0.5, 16, 12), lit(0));
        ball.scale.setScalar(this.size);
        ball.material.depthTest = !this.isThrough;
        ball.renderOrder = 10;
        balls.push(ball);
        group.add(ball);
      }
      balls.forEach((ball, i) => {
        ball.visible = points[i]?.clamped ?? false;
        if (!ball.visible) return;
        ball.position.copy(points[i].at);
        ball.material.color.setHex(colour);
      });
    };
  }

  forces(group) {
    const all = this.replay.soles.flatMap((sole) => sole.vertices.map((v) => ({ sole, v, arrow: new Arrow(group) })));
    const changing = this.replay.soles.filter((sole) => sole.points);
    const arrows = [];
    return (tick) => {
      for (const { sole, v, arrow } of all) {
        const colour = STATES[kindOf(sole.states[sole.state[tick]])];
        this.point(arrow, vectorAt(v.position, tick), vectorAt(v.force, tick), colour);
      }
      let used = 0;
      for (const sole of changing) {
        const colour = STATES[kindOf(sole.states[sole.state[tick]])];
        for (const { at, force } of contactsAt(sole, tick)) {
          if (used === arrows.length) arrows.push(this.added(new Arrow(group)));
          this.point(arrows[used++], at, force, colour);
        }
      }
      for (const arrow of arrows.slice(used)) this.point(arrow, null, null, 0);
    };
  }

  // An arrow that is made while the page is in use is visible as the others are.
  added(arrow) {
    arrow.shaft.material.depthTest = !this.isThrough;
    return arrow;
  }

  // The sum of a sole's forces, at the mean of its vertices weighted by their normal parts.
  resultants(group) {
    const all = this.replay.soles.map((sole) => ({ sole, arrow: new Arrow(group) }));
    return (tick) => {
      for (const { sole, arrow } of all) {
        const sum = vectorAt(sole.force, tick);
        const at = new THREE.Vector3();
        let weights = 0;
        for (const vertex of contactsAt(sole, tick)) {
          const weight = Math.max(0, vertex.force?.dot(sum) ?? 0);
          at.addScaledVector(vertex.at, weight);
          weights += weight;
        }
        const colour = STATES[kindOf(sole.states[sole.state[tick]])];
        this.point(arrow, at.divideScalar(weights || 1), weights > 0 ? sum : null, colour);
      }
    };
  }

  external(group) {
    const arrows = [];
    return (tick) => {
      const numbers = listAt(this.replay.external, tick);
      while (6 * arrows.length < numbers.length) arrows.push(new Arrow(group));
      arrows.forEach((arrow, i) => {
        const [at, force] = [6 * i, 6 * i + 3].map((from) => vectorOf(numbers.subarray(from, from + 3)));
        this.point(arrow, at, force, COLOURS.external);
      });
    };
  }

  // Places the arrow of a force; hides it without a force.
  point(arrow, at, force, colour) {
    const usable = at && force && Number.isFinite(force.length());
    arrow.put(at, usable ? force.clone().multiplyScalar(this.scale * this.metresPerNewton) : null, colour, this.size);
  }

  path(group) {
    const geometry = geometryOf(this.replay.com);
    const whole = new THREE.Line(geometry, new THREE.LineBasicMaterial({ color: COLOURS.path, transparent: true, opacity: 0.25 }));
    const past = new THREE.Line(geometryOf(this.replay.com), new THREE.LineBasicMaterial({ color: COLOURS.path, transparent: true }));
    whole.frustumCulled = past.frustumCulled = false;
    group.add(whole, past);
    return (tick) => past.geometry.setDrawRange(0, tick + 1);
  }

  polygon(group) {
    const outline = new THREE.LineLoop(new THREE.BufferGeometry(), new THREE.LineBasicMaterial({ color: COLOURS.polygon, transparent: true }));
    const fill = new THREE.Mesh(new THREE.BufferGeometry(), flat(COLOURS.polygon, 0.18));
    outline.frustumCulled = fill.frustumCulled = false;
    group.add(fill, outline);
    return (tick) => {
      setPolygon(outline, fill, listAt(this.replay.polygon, tick).slice());
    };
  }

  // The segment between the nearest points of the two bodies.
  nearest(group) {
    const { first, second, distance, margin } = this.replay.nearest;
    const rod = new THREE.Mesh(new THREE.CylinderGeometry(0.5, 0.5, 1, 12).rotateX(Math.PI / 2).translate(0, 0, 0.5), lit(0));
    const balls = [0, 1].map(() => new THREE.Mesh(new THREE.SphereGeometry(0.5, 16, 12), rod.material));
    balls.forEach((ball) => ball.scale.setScalar(0.8 * this.size));
    group.add(rod, ...balls);
    return (tick) => {
      const [a, b] = [vectorAt(first, tick), vectorAt(second, tick)];
      balls.forEach((ball) => (ball.visible = a !== null && b !== null));
      rod.visible = balls[0].visible && a.distanceTo(b) > 1e-6;
      if (!balls[0].visible) return;
      balls[0].position.copy(a);
      balls[1].position.copy(b);
      rod.material.color.setHex(NEARNESS[nearness(distance[tick], margin)]);
      if (!rod.visible) return;
      const along = b.clone().sub(a);
      rod.position.copy(a);
      rod.scale.set(0.3 * this.size, 0.3 * this.size, along.length());
      rod.quaternion.setFromUnitVectors(new THREE.Vector3(0, 0, 1), along.normalize());
    };
  }

  // Label of the nearest bodies: position and text.
  nearestLabel(tick) {
    const { first, second, distance, pairs, pair } = this.replay.nearest;
    const [a, b] = [vectorAt(first, tick), vectorAt(second, tick)];
    if (!a || !b) return null;
    return { at: a.lerp(b, 0.5), text: `${pairs[pair[tick]]} ${(1000 * distance[tick]).toFixed(1)} mm` };
  }

  points(group) {
    const shows = this.replay.points.map((point) => this.ball(group, point.position, COLOURS.point, 1.5));
    return (tick) => shows.forEach((show) => show(tick));
  }
}

// An arrow: a shaft and a head along z, turned and scaled.
class Arrow {
  constructor(group) {
    const material = lit(0);
    this.shaft = new THREE.Mesh(new THREE.CylinderGeometry(0.5, 0.5, 1, 12).rotateX(Math.PI / 2).translate(0, 0, 0.5), material);
    this.head = new THREE.Mesh(new THREE.ConeGeometry(0.5, 1, 16).rotateX(Math.PI / 2).translate(0, 0, 0.5), material);
    this.group = new THREE.Group();
    this.group.add(this.shaft, this.head);
    this.shaft.renderOrder = this.head.renderOrder = 10;
    group.add(this.group);
  }

  put(at, along, colour, size) {
    const length = along ? along.length() : 0;
    this.group.visible = length > 1e-3;
    if (!this.group.visible) return;
    const width = Math.min(0.06 * length, 0.5 * size);
    const head = Math.min(0.3 * length, 2 * size);
    this.group.position.copy(at);
    this.group.quaternion.setFromUnitVectors(new THREE.Vector3(0, 0, 1), along.clone().normalize());
    this.shaft.scale.set(width, width, length - head);
    this.head.scale.set(2.5 * width, 2.5 * width, head);
    this.head.position.z = length - head;
    this.shaft.material.color.setHex(colour);
  }
}

// Vertices of a contact at a tick: position, force, and whether it is clamped.
function contactsAt(sole, tick) {
  if (!sole.points) {
    return sole.vertices.map((v) => ({
      at: vectorAt(v.position, tick),
      force: vectorAt(v.force, tick),
      clamped: v.clamped[tick] === 1,
    }));
  }
  const numbers = listAt(sole.points, tick);
  const found = [];
  for (let i = 0; i < numbers.length; i += 7) {
    const [at, force] = [i, i + 3].map((from) => vectorOf(numbers.subarray(from, from + 3)));
    found.push({ at, force, clamped: numbers[i + 6] === 1 });
  }
  return found;
}

// Gives an outline and its filling the corners of a polygon.
function setPolygon(outline, fill, corners) {
  const fan = [];
  for (let i = 1; 3 * (i + 1) < corners.length; i++) fan.push(0, i, i + 1);
  for (const [part, indices] of [[outline, null], [fill, new Uint32Array(fan)]]) {
    part.geometry.dispose();
    part.geometry = geometryOf(corners, indices);
    part.visible = corners.length >= (indices ? 9 : 6);
  }
}

// Classifies a distance by the margin of the scenario.
function nearness(distance, margin) {
  if (distance <= 0) return "overlap";
  return distance < margin ? "near" : "apart";
}

function vectorOf([x, y, z]) {
  return x === undefined ? null : new THREE.Vector3(x, y, z);
}

function lit(color) {
  return new THREE.MeshLambertMaterial({ color, transparent: true, depthTest: false });
}

function flat(color, opacity) {
  return new THREE.MeshBasicMaterial({ color, opacity, transparent: true, depthWrite: false, side: THREE.DoubleSide });
}

// A tenth of the widest sole, limited so that markers are visible and do not hide a foot.
function markerSize(replay, extent) {
  const soles = (replay.soles ?? []).map((sole) => contactsAt(sole, 0).map(({ at }) => at));
  const widths = soles.flatMap((corners) => corners.map((corner) => corner.distanceTo(corners[0])));
  const width = Math.max(0, ...widths);
  return Math.min(width > 0 ? Math.min(Math.max(0.1 * width, 0.005), 0.05) : Infinity, 0.04 * extent);
}

// The typical force: the median of the floor's total force while it is not 0, else of the external forces.
function usualForce(replay) {
  const sizes = [];
  for (let tick = 0; tick < replay.times.length; tick++) {
    const sum = new THREE.Vector3();
    for (const sole of replay.soles ?? []) sum.add(vectorAt(sole.force, tick) ?? new THREE.Vector3());
    if (sum.length() > 0) sizes.push(sum.length());
  }
  if (sizes.length === 0 && replay.external) {
    const { numbers } = replay.external;
    for (let i = 3; i < numbers.length; i += 6) sizes.push(Math.hypot(numbers[i], numbers[i + 1], numbers[i + 2]));
  }
  sizes.sort((a, b) => a - b);
  return sizes[sizes.length >> 1] || 1;
}
