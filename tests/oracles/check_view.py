#!/usr/bin/env python3
"""Plays runs in headless Chromium: `runner view` as a file and as a server, driven by its own slider, buttons and keys.

    check_view.py RUNNER LOG|RUN-FOLDER... [--pictures FOLDER]

Checked: an empty console, no request except to the page itself, a non-empty picture, a slider that
moves the robot to its logged pose, keys, events, playing, speed, legend, marks, styles and the
robot's own view. With `--pictures` the script stores a screenshot of each run, at its middle.

The browser is $CHROMIUM, or the first of chromium, chromium-browser, google-chrome that is
installed; without one the script prints that it checks nothing. The Python standard library is
enough.
"""

import json
import re
import subprocess
import sys
import tempfile
from html import unescape
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
from check_report import browser, requests  # noqa: E402

# Software rendering, so that machines without a graphics processor give the same result.
OPTIONS = ["--headless=new", "--no-sandbox", "--disable-dev-shm-usage", "--no-first-run", "--disable-background-networking",
           "--disable-component-update", "--disable-sync", "--use-angle=swiftshader", "--enable-unsafe-swiftshader",
           "--host-resolver-rules=MAP * ~NOTFOUND, EXCLUDE 127.0.0.1", "--enable-logging=stderr", "--v=0",
           "--window-size=1280,860", "--virtual-time-budget=20000"]

# Runs in the page after loading, through its elements as a user would. Reports errors as text.
PROBE = r"""
ready.then(async () => {
  const wrong = [];
  const check = (holds, text) => holds || wrong.push(text);
  const id = (name) => document.getElementById(name);
  const { clock, replay, shapes, marks } = viewer;
  const last = replay.times.length - 1;
  const press = (key, more) => document.body.dispatchEvent(new KeyboardEvent("keydown", { key, bubbles: true, cancelable: true, ...more }));
  const put = (name, value, kind) => { id(name).value = value; id(name).dispatchEvent(new Event(kind)); };
  const tick = (box) => { box.checked = !box.checked; box.dispatchEvent(new Event("change")); };
  const picture = (box) => {
    viewer.draw();
    const canvas = id("canvas");
    const whole = canvas.getBoundingClientRect();
    const { left, top, width, height } = box ?? whole;
    const copy = new OffscreenCanvas(width, height);
    const context = copy.getContext("2d");
    const ratio = canvas.width / whole.width;
    context.drawImage(canvas, ratio * (left - whole.left), ratio * (top - whole.top), ratio * width, ratio * height, 0, 0, width, height);
    return new Uint32Array(context.getImageData(0, 0, width, height).data.buffer);
  };
  const changed = (a, b) => a.reduce((n, pixel, i) => n + (pixel !== b[i]), 0);

  const boxes = [...document.querySelectorAll("#layers input")];
  const first = picture();
  check(new Set(first).size > 200, `only ${new Set(first).size} colours in the picture`);

  // The slider moves the robot to where the log has it.
  id("follow").click();
  const moving = replay.frames.filter((f) => !f.fixed && f.parent === replay.world);
  check(moving.length === 1 || shapes.base !== replay.world, "no base");
  for (const to of [Math.floor(last / 2), last]) {
    put("slider", to, "input");
    check(clock.tick === to, `the slider at ${to} leads to tick ${clock.tick}`);
    check(id("time").value === `${replay.times[to].toFixed(3)} s`, `time ${id("time").value}`);
    for (const frame of replay.frames.filter((f) => f.parent === replay.world)) {
      const at = shapes.at(frame.name);
      const from = frame.fixed ? 0 : 7 * to;
      const off = Math.hypot(at.x - frame.poses[from], at.y - frame.poses[from + 1], at.z - frame.poses[from + 2]);
      check(off < 1e-6, `${frame.name} is ${off} m from where the log has it`);
    }
  }
  const still = replay.frames.every((f) => f.fixed || f.poses.every((x, i) => Math.abs(x - f.poses[i % 7]) < 2e-3));
  boxes.forEach((box) => box.checked && tick(box));
  put("slider", 0, "input");
  const start = picture();
  // It may come back to where it began.
  const moves = [0.1, 0.3, 0.5, 0.7, 0.9, 1].some((part) => {
    put("slider", Math.floor(part * last), "input");
    return changed(start, picture()) > 50;
  });
  check(still || moves, "the robot does not move in the picture");
  put("slider", 0, "input");
  check(changed(start, picture()) === 0, "the start looks different the second time");

  // Every mark is to be seen at one of some ticks.
  for (const box of boxes) {
    tick(box);
    const seen = [0, 0.2, 0.4, 0.5, 0.6, 0.8, 1].some((part) => {
      put("slider", Math.floor(part * last), "input");
      const on = picture();
      tick(box);
      const off = picture();
      tick(box);
      return changed(on, off) > 0;
    });
    const name = box.id.slice(6);
    // Forces and points may act or stand at other times than those.
    check(seen || ["external", "points"].includes(name) || (replay.soles && replay.soles.every((s) => s.states.length === 1 && s.states[0] === "free")),
      `${name}: no mark to be seen`);
    tick(box);
  }
  boxes.forEach((box) => tick(box));

  // States by colour.
  const legend = [...document.querySelectorAll("#legend li")];
  check(legend.length === 7, `${legend.length} entries in the legend`);
  const painted = new Map(legend.map((li) => [li.textContent, getComputedStyle(li.firstChild).backgroundColor]));
  check(new Set(painted.values()).size === 7, "two states of one colour");
  for (const text of ["free", "face, static", "edge, static", "vertex, static", "face, dynamic", "edge, dynamic", "vertex, dynamic"])
    check(painted.has(text), `no ${text} in the legend`);
  for (const [s, sole] of (replay.soles ?? []).entries()) {
    for (const [code, state] of sole.states.entries()) {
      put("slider", sole.state.indexOf(code), "input");
      const row = document.querySelectorAll("#soles tr")[s];
      const text = state.replace(/-\d+/, "").replace("-", ", ");
      check(row.textContent.includes(state), `${sole.name}: ${row.textContent} instead of ${state}`);
      check(getComputedStyle(row.querySelector(".swatch")).backgroundColor === painted.get(text), `${state} has another colour than the legend`);
    }
  }

  // Keys.
  press("Home");
  check(clock.tick === 0, "Home");
  press("ArrowRight");
  check(clock.tick === Math.min(1, last), "right");
  press("ArrowLeft");
  check(clock.tick === 0, "left");
  press("End");
  check(clock.tick === last, "End");
  press("ArrowLeft", { shiftKey: true });
  check(last < 3 || (clock.tick < last && replay.times[last] - replay.times[clock.tick] < 0.1 + 2 * (replay.times[1] - replay.times[0])), "shift and left");
  press("Home");
  const events = replay.events.filter((e) => clock.after(e) > 0);
  press("n");
  check(events.length === 0 || clock.tick === Math.min(...events.map((e) => clock.after(e))), "next event");
  const buttons = [...document.querySelectorAll("#events button")];
  check(buttons.length === Math.min(replay.events.length, 3000), `${buttons.length} events listed of ${replay.events.length}`);
  if (buttons.length > 0) {
    const middle = Math.floor(buttons.length / 2);
    buttons[middle].click();
    check(replay.times[clock.tick] + 1e-9 >= replay.events[middle].time || clock.tick === last, "an event leads to before it");
    check(document.querySelector("#events .now") !== null, "no event is marked");
  }

  // Playing, at two speeds, on a clock of our own.
  const played = (speed) => {
    put("speed", speed, "change");
    press("Home");
    press(" ");
    for (let ms = 0; ms <= 200; ms += 10) clock.advance(1000 + ms);
    const time = clock.time;
    clock.play(false);
    return time - replay.times[0];
  };
  const long = replay.times[last] - replay.times[0];
  for (const speed of [0.1, 1, 10])
    check(Math.abs(played(speed) - Math.min(0.2 * speed, long)) < 1e-9, `200 ms at ${speed} take ${played(speed)} s`);
  const speeds = [...id("speed").options].map((o) => Number(o.value));
  check(Math.min(...speeds) === 0.1 && Math.max(...speeds) === 10, `speeds ${speeds}`);

  // Styles, views, the robot's own view.
  press("Home");
  const solid = picture();
  press("s");
  check(changed(solid, picture()) > 50, "translucent looks as solid does");
  press("s");
  check(changed(solid, picture()) > 50, "wireframe looks as solid does");
  press("s");
  press("s");
  check(changed(solid, picture()) === 0, "solid again looks different");
  press("3");
  check(changed(solid, picture()) > 50, "from above it looks the same");
  press("4");
  check(id("eye-frame").value === viewer.eye.frame && viewer.eye.frames.length >= 1, "frames of the camera");
  const heights = viewer.eye.frames.map((name) => shapes.at(name).applyMatrix4(shapes.groups.get(shapes.base).matrixWorld.clone().invert()).z);
  check(heights[viewer.eye.frames.indexOf(viewer.eye.frame)] > Math.max(...heights) - 1e-5, "the camera is not on the highest frame");
  const box = id("eye").getBoundingClientRect();
  const seen = picture(box);
  check(new Set(seen).size > 2, "the robot sees nothing");
  press("c");
  check(changed(seen, picture(box)) > 50, "its view cannot be put out");
  press("c");
  if (viewer.eye.frames.length > 1) {
    const others = viewer.eye.frames.filter((name) => name !== viewer.eye.frame);
    check(others.some((name) => (put("eye-frame", name, "change"), changed(seen, picture(box)) > 50)), "all frames see the same");
  }
  return { wrong, ticks: last + 1, events: replay.events.length, frames: replay.frames.length, shapes: replay.shapes.length };
}).catch((error) => ({ wrong: [`${error.stack}`] })).then((result) => {
  const report = document.createElement("pre");
  report.id = "report";
  report.textContent = JSON.stringify(result);
  document.body.append(report);
});
"""


def run(program, address, place, *options):
    """Runs the browser with its own profile; returns the document and standard error."""
    command = [program, *OPTIONS, f"--user-data-dir={place / 'profile'}", *options, address]
    done = subprocess.run(command, capture_output=True, text=True, timeout=300)
    return done.stdout, [line for line in done.stderr.splitlines() if "CONSOLE" in line]


def check_file(program, runner, log, place):
    """Checks the standalone page; returns its errors, its report of the run, and the page."""
    page, probed, record = place / "page.html", place / "probed.html", place / "file.json"
    subprocess.run([runner, "view", log, "-o", page], check=True, capture_output=True)
    probed.write_text(page.read_text().replace("</body>", f"<script>{PROBE}</script></body>"))
    document, console = run(program, probed.as_uri(), place, "--dump-dom", f"--log-net-log={record}")
    wrong = [f"console: {line}" for line in console]
    wrong += [f"requested {url}" for url in requests(record) if url != probed.as_uri() and not url.startswith(("data:", "blob:"))]
    report = re.search(r'<pre id="report">(.*?)</pre>', document, re.DOTALL)
    if not report:
        return [*wrong, "the run never came"], {}, page
    result = json.loads(unescape(report.group(1)))
    return wrong + result.pop("wrong"), result, page


def check_served(program, runner, log, place):
    """The same from the server: the page must show the run and request nothing else."""
    record = place / "served.json"
    server = subprocess.Popen([runner, "view", log], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
    try:
        address = server.stdout.readline().strip()
        document, console = run(program, address, place, "--dump-dom", f"--log-net-log={record}")
    finally:
        server.terminate()
        server.wait()
    wrong = [f"served, console: {line}" for line in console]
    requested = {url for url in requests(record) if not url.startswith(("data:", "blob:"))}
    wrong += [f"served, requested {url}" for url in requested if not url.startswith(address)]
    if address + "run/0/data" not in requested:
        wrong.append("served, it never requested its run")
    if not re.search(r'<select id="eye-frame"[^>]*><option', document):
        wrong.append("served, the run never came")
    return wrong


def main(arguments):
    if len(arguments) < 2:
        print(__doc__, file=sys.stderr)
        return 2
    program = browser()
    if program is None:
        print("skipped: no Chromium")
        return 0
    pictures = None
    if "--pictures" in arguments:
        at = arguments.index("--pictures")
        pictures = Path(arguments[at + 1])
        arguments = arguments[:at] + arguments[at + 2 :]
        pictures.mkdir(parents=True, exist_ok=True)
    runner, failed = arguments[0], False
    for number, log in enumerate(arguments[1:]):
        with tempfile.TemporaryDirectory() as name:
            place = Path(name)
            wrong, report, page = check_file(program, runner, log, place)
            wrong += check_served(program, runner, log, place)
            if pictures:
                run(program, page.as_uri() + "#t=0.5", place, f"--screenshot={pictures / f'{number}.png'}")
        failed |= bool(wrong)
        print(f"{log}: {'; '.join(wrong) if wrong else 'good'} {report}")
    return int(failed)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
