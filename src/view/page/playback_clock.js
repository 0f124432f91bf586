// Selects the shown tick: playing, stepping, jumping.

const SPEEDS = [0.1, 0.2, 0.5, 1, 2, 5, 10];

class PlaybackClock {
  constructor(times, events, show) {
    this.times = times;
    this.events = events;
    this.show = show;
    this.speed = 1;
    this.playing = false;
    this.time = times[0];
    this.tick = 0;
  }

  // Shows a tick.
  to(tick) {
    this.tick = Math.min(Math.max(tick, 0), this.times.length - 1);
    this.time = this.times[this.tick];
    this.show(this.tick);
  }

  at(time) {
    this.to(tickAt(this.times, time));
  }

  get end() {
    return this.times[this.times.length - 1];
  }

  play(on) {
    if (on && this.tick === this.times.length - 1) this.to(0);
    this.playing = on;
    this.then = undefined;
  }

  // Advances the playback to `now`, ms of the browser's clock, and shows the tick of that time.
  advance(now) {
    if (!this.playing) return;
    // A page that was hidden continues where it stopped.
    const passed = this.then === undefined ? 0 : Math.min(now - this.then, 250) / 1000;
    this.then = now;
    const time = this.time + this.speed * passed;
    const tick = tickAt(this.times, time);
    if (tick !== this.tick) this.to(tick);
    this.time = Math.min(time, this.end);
    if (this.time >= this.end) this.play(false);
  }

  faster(steps) {
    const at = SPEEDS.indexOf(this.speed);
    this.speed = SPEEDS[Math.min(Math.max(at + steps, 0), SPEEDS.length - 1)];
  }

  // The first tick at or after an event.
  after(event) {
    const tick = tickAt(this.times, event.time);
    return this.times[tick] + 5e-10 < event.time ? Math.min(tick + 1, this.times.length - 1) : tick;
  }

  // Jumps to the nearest event at a later (direction 1) or earlier (-1) tick.
  jump(direction) {
    const ticks = this.events.map((event) => this.after(event));
    const beyond = ticks.filter((tick) => (direction > 0 ? tick > this.tick : tick < this.tick));
    if (beyond.length > 0) this.to(direction > 0 ? Math.min(...beyond) : Math.max(...beyond));
  }
}
