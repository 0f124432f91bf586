// Canvas, lights, and the user's camera.

class Stage {
  constructor(canvas, extent) {
    this.renderer = new THREE.WebGLRenderer({ canvas, antialias: true });
    this.renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
    this.scene = new THREE.Scene();
    const dark = window.matchMedia("(prefers-color-scheme: dark)");
    const paint = () => {
      this.scene.background = new THREE.Color(dark.matches ? 0x1a1f24 : 0xeef2f6);
      this.changed();
    };
    this.extent = extent;
    this.camera = new THREE.PerspectiveCamera(40, 1, 0.01 * extent, 100 * Math.max(extent, 1));
    this.camera.up.set(0, 0, 1);
    this.scene.add(new THREE.HemisphereLight(0xffffff, 0x8a8f98, 2.2));
    this.sun = new THREE.DirectionalLight(0xffffff, 1.6);
    this.scene.add(this.sun, this.sun.target);
    this.controls = new THREE.OrbitControls(this.camera, canvas);
    this.controls.addEventListener("change", () => this.changed());
    this.follow = true;
    this.stale = true;
    this.extras = [];
    dark.addEventListener("change", paint);
    paint();
    new ResizeObserver(() => this.fit()).observe(canvas.parentElement);
  }

  // Schedules a redraw with the next frame of the browser.
  changed() {
    this.stale = true;
  }

  fit() {
    const { clientWidth: width, clientHeight: height } = this.renderer.domElement.parentElement;
    if (width === 0 || height === 0) return;
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    this.changed();
  }

  // Directs the camera at a point from a direction, at a distance at which the robot fills the picture.
  look(at, from) {
    const away = new THREE.Vector3(...from).normalize().multiplyScalar(2.7 * this.extent);
    this.controls.target.copy(at);
    this.camera.position.copy(at).add(away);
    this.controls.update();
    this.changed();
  }

  // Moves the camera with the robot, if it follows.
  accompany(to) {
    if (this.last && this.follow) {
      const step = to.clone().sub(this.last);
      this.controls.target.add(step);
      this.camera.position.add(step);
      this.controls.update();
    }
    this.last = to.clone();
    this.changed();
  }

  draw() {
    this.stale = false;
    this.sun.position.copy(this.camera.position).add(new THREE.Vector3(0.4, -0.3, 1).multiplyScalar(this.extent));
    this.sun.target.position.copy(this.controls.target);
    const { clientWidth: width, clientHeight: height } = this.renderer.domElement;
    this.renderer.setScissorTest(false);
    this.renderer.setViewport(0, 0, width, height);
    this.renderer.render(this.scene, this.camera);
    for (const extra of this.extras) extra.draw(this.renderer, this.scene);
  }
}
