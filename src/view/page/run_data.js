// Decodes the bytes of a run, encoded by packed_run.rs, into arrays of numbers.

const FORMAT = 1;

// Reads the bytes from the page, or loads them from the server.
async function fetchRun() {
  const inside = document.getElementById("data").textContent.trim();
  if (inside === "") {
    const answer = await fetch("data");
    if (!answer.ok) throw new Error(await answer.text());
    return answer.arrayBuffer();
  }
  const text = atob(inside);
  const compressed = new Uint8Array(text.length);
  for (let i = 0; i < text.length; i++) compressed[i] = text.charCodeAt(i);
  return new Response(new Blob([compressed]).stream().pipeThrough(new DecompressionStream("gzip"))).arrayBuffer();
}

function unpack(buffer) {
  const length = new DataView(buffer).getUint32(0, true);
  const head = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 4, length)));
  if (head.format !== FORMAT) throw new Error(`this page shows format ${FORMAT}, not ${head.format}`);
  const base = Math.ceil((4 + length) / 8) * 8;
  const column = (Kind) => (place) => new Kind(buffer, base + place.at, place.n);
  const [floats, doubles, whole, bytes] = [Float32Array, Float64Array, Uint32Array, Uint8Array].map(column);
  const some = (place, read) => (place === null || place === undefined ? null : read(place));
  const lists = (place) => ({ starts: whole(place.starts), numbers: floats(place.numbers) });
  const times = doubles(head.times);
  return {
    run: head.run,
    times,
    world: head.world,
    frames: head.frames.map((f) => ({ ...f, poses: floats(f.poses) })),
    shapes: head.shapes.map((s) => ({ ...s, points: some(s.points, floats), indices: some(s.indices, whole) })),
    com: some(head.com, floats),
    cop: some(head.cop, floats),
    stable: some(head.stable, floats),
    polygon: some(head.polygon, lists),
    external: some(head.external, lists),
    points: (head.points ?? []).map((p) => ({ name: p.name, position: floats(p.position) })),
    nearest: some(head.nearest, (n) => ({
      margin: n.margin,
      pairs: n.pairs,
      pair: whole(n.pair),
      distance: floats(n.distance),
      first: floats(n.first),
      second: floats(n.second),
    })),
    soles: some(head.soles, (all) =>
      all.map((s) => ({
        name: s.name,
        states: s.states,
        state: bytes(s.state),
        force: floats(s.force),
        points: some(s.points, lists),
        vertices: s.vertices.map((v) => ({
          clamped: bytes(v.clamped),
          position: floats(v.position),
          force: floats(v.force),
        })),
      })),
    ),
    events: head.events,
  };
}

// The last tick at or before a time. Times are logged to the nanosecond.
function tickAt(times, time) {
  let [low, high] = [0, times.length];
  while (low < high) {
    const middle = (low + high) >> 1;
    if (times[middle] <= time + 5e-10) low = middle + 1;
    else high = middle;
  }
  return Math.max(0, low - 1);
}

// The vector of a tick in a column; null where it is absent.
function vectorAt(column, tick) {
  const [x, y, z] = column.subarray(3 * tick, 3 * tick + 3);
  return Number.isNaN(x) ? null : new THREE.Vector3(x, y, z);
}

// The numbers of a tick in columns of lists.
function listAt(lists, tick) {
  return lists.numbers.subarray(lists.starts[tick], lists.starts[tick + 1]);
}
