// Assembles the viewer and handles mouse and keyboard.

const LAYERS = [
  ["states", "contact states", null],
  ["forces", "contact forces, per vertex", null],
  ["resultants", "contact forces, summed", null],
  ["external", "external forces", COLOURS.external],
  ["com", "centre of mass", COLOURS.com],
  ["path", "its path", COLOURS.path],
  ["cop", "zero-moment point", COLOURS.cop],
  ["polygon", "support polygon", COLOURS.polygon],
  ["stable", "point of optimal stability", COLOURS.stable],
  ["nearest", "nearest bodies of the robot", NEARNESS.apart],
  ["points", "points of tasks", COLOURS.point],
];
const HIDDEN_AT_FIRST = ["resultants"];
const VIEWS = { 1: [1, 0, 0.12], 2: [0, -1, 0.12], 3: [0, -0.001, 1], 4: [1, -1.4, 0.6] };
// Longest list of events; longer ones slow the page down.
const MAX_EVENTS = 3000;

const byId = (id) => document.getElementById(id);
const css = (colour) => `#${colour.toString(16).padStart(6, "0")}`;

function element(name, properties = {}, ...children) {
  const made = Object.assign(document.createElement(name), properties);
  made.append(...children);
  return made;
}

function swatch(colour) {
  const made = element("span", { className: "swatch" });
  made.style.background = css(colour);
  return made;
}

class Viewer {
  constructor(replay) {
    this.replay = replay;
    this.shapes = new Shapes(replay);
    const { middle, extent } = this.shapes.bounds();
    this.stage = new Stage(byId("canvas"), extent);
    this.marks = new Markers(replay, extent);
    this.stage.scene.add(this.shapes.root, this.marks.root);
    this.eye = new RobotCamera(this.shapes, this.marks, extent, byId("eye"));
    this.stage.extras.push(this.eye);
    this.clock = new PlaybackClock(replay.times, replay.events, (tick) => this.show(tick));
    this.stage.fit();
    this.centre = middle.clone().sub(this.shapes.followed());
    this.describe();
    this.controls();
    this.listEvents();
    this.clock.to(0);
    this.stage.look(middle, VIEWS[4]);
    const start = /[#&]t=([0-9.]+)/.exec(location.hash);
    if (start) this.clock.at(Number(start[1]));
    const loop = (now) => {
      this.clock.advance(now);
      this.buttons();
      if (this.stage.stale) this.draw();
      requestAnimationFrame(loop);
    };
    requestAnimationFrame(loop);
  }

  draw() {
    this.stage.draw();
    this.label();
  }

  show(tick) {
    this.shapes.show(tick);
    this.marks.show(tick);
    this.stage.accompany(this.shapes.followed());
    byId("slider").value = tick;
    byId("time").value = `${this.replay.times[tick].toFixed(3)} s`;
    for (const [i, sole] of (this.replay.soles ?? []).entries()) {
      const state = sole.states[sole.state[tick]];
      const row = this.rows[i];
      row.swatch.style.background = css(STATES[kindOf(state)]);
      row.state.textContent = state;
      row.force.textContent = `${vectorAt(sole.force, tick).length().toFixed(1)} N`;
    }
    this.markEvent();
  }

  describe() {
    const { run, soles } = this.replay;
    document.title = `${run.scenario} ${run.key} · stiction`;
    byId("scenario").textContent = run.scenario;
    const early = run.complete ? "" : ", ended early";
    byId("run").textContent = `${run.robot}, ${run.method}, ${run.key}, ${run.program}${early}`;
    this.rows = (soles ?? []).map((sole) => {
      const row = { swatch: swatch(STATES.free), state: element("span"), force: element("td") };
      byId("soles").append(element("tr", {}, element("td", {}, sole.name), element("td", {}, row.swatch, row.state), row.force));
      return row;
    });
    const legend = Object.keys(STATES).map((kind) => element("li", {}, swatch(STATES[kind]), kind.replace("-", ", ")));
    byId("legend").append(...legend);
    if (!soles) byId("soles").replaceWith(element("p", {}, "The log has no topic `contact`."));
  }

  controls() {
    const on = (id, kind, act) => byId(id).addEventListener(kind, act);
    for (const [name, label, colour] of LAYERS) {
      if (!(name in this.marks.layers)) continue;
      const box = element("input", { type: "checkbox", checked: !HIDDEN_AT_FIRST.includes(name), id: `layer-${name}` });
      const set = () => {
        this.marks.toggle(name, box.checked);
        this.stage.changed();
      };
      box.addEventListener("change", set);
      set();
      const sign = colour === null ? [] : [swatch(colour)];
      byId("layers").append(element("li", {}, element("label", {}, box, " ", ...sign, label)));
    }
    byId("speed").append(...SPEEDS.map((speed) => element("option", { value: speed }, `${speed} ×`)));
    byId("style").append(...STYLES.map((style) => element("option", { value: style }, style)));
    byId("eye-frame").append(...this.eye.frames.map((name) => element("option", { value: name }, name)));
    byId("eye-frame").value = this.eye.frame;
    byId("slider").max = this.replay.times.length - 1;
    on("slider", "input", () => this.clock.to(Number(byId("slider").value)));
    on("play", "click", () => this.clock.play(!this.clock.playing));
    on("next", "click", () => this.clock.jump(1));
    on("previous", "click", () => this.clock.jump(-1));
    on("speed", "change", () => (this.clock.speed = Number(byId("speed").value)));
    on("style", "change", () => this.restyle());
    on("scale", "input", () => this.rescale());
    on("follow", "change", () => (this.stage.follow = byId("follow").checked));
    on("through", "change", () => {
      this.marks.through(byId("through").checked);
      this.stage.changed();
    });
    on("eye-on", "change", () => this.reframe());
    on("eye-frame", "change", () => this.reframe());
    for (const button of document.querySelectorAll("#views button"))
      button.addEventListener("click", () => this.turn(button.dataset.view));
    document.addEventListener("keydown", (event) => this.key(event));
    this.rescale();
    this.reframe();
    this.buttons();
  }

  buttons() {
    byId("sign").setAttribute("d", this.clock.playing ? "M3 2h3.5v12H3zM9.5 2H13v12H9.5z" : "M3 2v12l11-6z");
    byId("speed").value = this.clock.speed;
  }

  restyle() {
    this.shapes.style(byId("style").value);
    this.stage.changed();
  }

  // Scales the arrows; at 1 the typical force is as long as half the robot.
  rescale() {
    this.marks.scale = 10 ** Number(byId("scale").value);
    this.marks.show(this.clock.tick);
    byId("scale-is").value = `${Number((0.1 / (this.marks.scale * this.marks.metresPerNewton)).toPrecision(2))} N per 0.1 m`;
    this.stage.changed();
  }

  reframe() {
    this.eye.on = byId("eye-on").checked;
    byId("eye").hidden = !this.eye.on;
    this.eye.choose(byId("eye-frame").value);
    byId("eye-name").textContent = this.eye.frame;
    this.shapes.show(this.clock.tick);
    this.stage.changed();
  }

  turn(view) {
    this.stage.look(this.shapes.followed().add(this.centre), VIEWS[view]);
  }

  key(event) {
    if (event.ctrlKey || event.altKey || event.metaKey || event.target.closest("select, input:not(#slider), summary")) return;
    const { clock } = this;
    const flip = (id) => byId(id).click();
    const style = byId("style");
    const actions = {
      " ": () => clock.play(!clock.playing),
      ArrowRight: () => (event.shiftKey ? clock.at(clock.time + 0.1) : clock.to(clock.tick + 1)),
      ArrowLeft: () => (event.shiftKey ? clock.at(clock.time - 0.1) : clock.to(clock.tick - 1)),
      Home: () => clock.to(0),
      End: () => clock.to(clock.times.length - 1),
      n: () => clock.jump(1),
      p: () => clock.jump(-1),
      "+": () => clock.faster(1),
      "-": () => clock.faster(-1),
      f: () => flip("follow"),
      c: () => flip("eye-on"),
      s: () => {
        style.selectedIndex = (style.selectedIndex + 1) % STYLES.length;
        this.restyle();
      },
    };
    const act = actions[event.key] ?? actions[event.key.toLowerCase()] ?? (event.key in VIEWS && (() => this.turn(event.key)));
    if (!act) return;
    event.preventDefault();
    act();
  }

  listEvents() {
    const { events, times } = this.replay;
    const kinds = [...new Set(events.map((event) => event.kind))].sort();
    byId("kinds").append(element("option", { value: "" }, "all kinds"), ...kinds.map((kind) => element("option", { value: kind }, kind)));
    const notches = new Set(events.map((event) => ((100 * this.clock.after(event)) / Math.max(1, times.length - 1)).toFixed(1)));
    for (const at of notches) {
      const notch = element("i");
      notch.style.left = `${at}%`;
      byId("ticks").append(notch);
    }
    const fill = () => {
      const kind = byId("kinds").value;
      const selected = events.filter((event) => kind === "" || event.kind === kind);
      this.listed = selected.slice(0, MAX_EVENTS).map((event) => {
        const text = event.message || event.subject;
        const button = element("button", {}, element("b", {}, event.time.toFixed(3)), ` ${event.kind} ${text}`);
        button.addEventListener("click", () => this.clock.to(this.clock.after(event)));
        return { event, button };
      });
      byId("events").replaceChildren(...this.listed.map(({ button }) => element("li", {}, button)));
      byId("count").textContent = selected.length > MAX_EVENTS ? `the first ${MAX_EVENTS} of ${selected.length}` : `${selected.length}`;
      this.now = undefined;
      this.markEvent();
    };
    byId("kinds").addEventListener("change", fill);
    fill();
  }

  // Highlights the last event at or before the shown tick.
  markEvent() {
    const time = this.replay.times[this.clock.tick];
    const now = this.listed?.findLast(({ event }) => event.time <= time + 5e-10);
    if (now === this.now) return;
    this.now?.button.classList.remove("now");
    now?.button.classList.add("now");
    if (now) {
      const [box, item] = [byId("events"), now.button.parentElement];
      box.scrollTop = item.offsetTop - box.offsetTop - 0.5 * box.clientHeight;
    }
    this.now = now;
  }

  // Labels the points of tasks and the nearest bodies.
  label() {
    const { layers } = this.marks;
    const tick = this.clock.tick;
    const all = [];
    if (layers.points?.group.visible)
      all.push(...this.replay.points.map((point) => ({ at: vectorAt(point.position, tick), text: point.name })));
    if (layers.nearest?.group.visible) all.push(this.marks.nearestLabel(tick));
    const { clientWidth: width, clientHeight: height } = byId("canvas");
    const made = all.flatMap((one) => {
      const at = one?.at?.project(this.stage.camera);
      if (!at || Math.abs(at.z) > 1) return [];
      const label = element("span", {}, one.text);
      label.style.left = `${(0.5 + 0.5 * at.x) * width}px`;
      label.style.top = `${(0.5 - 0.5 * at.y) * height}px`;
      return [label];
    });
    byId("labels").replaceChildren(...made);
  }
}

function showError(error) {
  byId("error").hidden = false;
  byId("error").textContent = `This run cannot be shown: ${error.message}`;
}

window.ready = fetchRun()
  .then((buffer) => (window.viewer = new Viewer(unpack(buffer))))
  .catch((error) => {
    showError(error);
    throw error;
  });
