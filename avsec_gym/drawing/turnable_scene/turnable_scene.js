"use strict";
// Scenes that turn: lines and boxes through a pinhole, the farthest first; no library is needed.
(() => {
  const NEAR = 0.3;
  const VIEWS = { behind: [0.25, 0.42, 24], above: [0, 1.45, 40] };
  const still = matchMedia("(prefers-reduced-motion: reduce)");

  const corners = ({ size: [length, width, height], bottom }, [x, y, heading]) => {
    const cos = Math.cos(heading), sin = Math.sin(heading);
    const at = (along, across, up) =>
      [x + cos * along - sin * across, y + sin * along + cos * across, bottom + up];
    const [a, b] = [length / 2, width / 2];
    return [0, height].flatMap((up) =>
      [at(a, b, up), at(a, -b, up), at(-a, -b, up), at(-a, b, up)]);
  };
  const FACES = [[0, 1, 2, 3], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]];

  const points = (text) => {
    const bytes = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
    const view = new DataView(bytes.buffer), found = new Float32Array(bytes.length / 2);
    for (let i = 0; i < found.length; i += 1) found[i] = view.getInt16(2 * i, true) / 100;
    return found;
  };

  class Turnable {
    constructor(root) {
      this.root = root;
      this.canvas = root.querySelector("canvas");
      this.context = this.canvas.getContext("2d");
      this.scene = JSON.parse(root.querySelector("script").textContent);
      this.points = points(this.scene.points);
      this.slider = root.querySelector(".time input");
      this.which = root.querySelector(".which");
      this.probe = root.querySelector("output");
      this.which.value = String(this.scene.drives.length - 1);
      this.look("behind");
      this.listen();
      this.choose();
    }

    look(name) {
      [this.turned, this.raised, this.away] = VIEWS[name];
      this.target = [name === "above" ? 16 : 10, 0, 0.5];
    }

    get drive() { return this.scene.drives[Number(this.which.value)]; }
    get step() { return Number(this.slider.value); }

    listen() {
      const { root, canvas } = this;
      const all = (name, event, then) =>
        root.querySelectorAll(name).forEach((one) => one.addEventListener(event, () => then(one)));
      all(".which", "input", () => this.choose());
      all(".layer", "input", () => this.draw());
      all(".view", "click", (one) => { this.look(one.value); this.draw(); });
      all(".nearer", "click", (one) => this.come(Number(one.value)));
      all(".play", "click", () => this.play());
      all(".time input", "input", () => { this.stop(); this.draw(); });
      canvas.addEventListener("pointerdown", (event) => {
        canvas.setPointerCapture(event.pointerId);
        canvas.focus({ preventScroll: true });
      });
      canvas.addEventListener("pointermove", (event) => {
        if (event.buttons) this.turn(-0.008 * event.movementX, 0.008 * event.movementY);
      });
      canvas.addEventListener("wheel", (event) => {
        // A page that is only scrolled past does not stick to the scene.
        if (document.activeElement !== canvas) return;
        event.preventDefault();
        this.come(Math.exp(0.001 * event.deltaY));
      }, { passive: false });
      canvas.addEventListener("keydown", (event) => {
        // The browser's own, such as to enlarge the page.
        if (event.ctrlKey || event.metaKey || event.altKey) return;
        const turns = { ArrowLeft: [0.1, 0], ArrowRight: [-0.1, 0], ArrowUp: [0, 0.1], ArrowDown: [0, -0.1] };
        const nears = { "+": 0.8, "=": 0.8, "-": 1.25 };
        if (turns[event.key]) this.turn(...turns[event.key]);
        else if (nears[event.key]) this.come(nears[event.key]);
        else if (event.key === " ") { if (!event.repeat) this.play(); }
        else return;
        event.preventDefault();
      });
      new ResizeObserver(() => this.draw()).observe(canvas);
      matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.draw());
      new MutationObserver(() => this.draw())
        .observe(document.documentElement, { attributes: true, attributeFilter: ["data-theme"] });
    }

    turn(aside, up) {
      this.turned += aside;
      this.raised = Math.min(Math.max(this.raised + up, 0.03), 1.5);
      this.draw();
    }

    come(factor) {
      this.away = Math.min(Math.max(this.away * factor, 4), 150);
      this.draw();
    }

    choose() {
      this.stop();
      this.slider.max = String(this.drive.car.length - 1);
      this.slider.value = still.matches ? "0" : this.slider.max;
      this.draw();
    }

    play() {
      if (this.playing) { this.stop(); return; }
      if (this.step === Number(this.slider.max)) this.slider.value = "0";
      this.root.querySelector(".play").textContent = "Stop";
      this.playing = setInterval(() => {
        this.slider.value = String(this.step + 1);
        this.draw();
        if (this.step >= Number(this.slider.max)) this.stop();
      }, 1000 * this.scene.dt);
    }

    stop() {
      clearInterval(this.playing);
      this.playing = undefined;
      this.root.querySelector(".play").textContent = "Drive";
    }

    // Into the camera's axes: right, up, ahead.
    seen([x, y, z]) {
      const [sa, ca, sp, cp] = this.angles;
      const [dx, dy, dz] = [x - this.target[0], y - this.target[1], z - this.target[2]];
      return [
        sa * dx - ca * dy,
        sp * (ca * dx + sa * dy) + cp * dz,
        cp * (ca * dx + sa * dy) - sp * dz + this.away,
      ];
    }

    pixel([right, up, ahead]) {
      return [this.middle[0] + this.focal * right / ahead, this.middle[1] - this.focal * up / ahead];
    }

    // The part of a polygon or a line before the camera.
    clipped(places, closed) {
      const found = [], count = places.length;
      places.forEach((here, i) => {
        if (here[2] > NEAR) found.push(here);
        const next = places[(i + 1) % count];
        if ((i + 1 < count || closed) && (here[2] > NEAR) !== (next[2] > NEAR)) {
          const share = (NEAR - here[2]) / (next[2] - here[2]);
          found.push(here.map((value, axis) => value + share * (next[axis] - value)));
        }
      });
      return found;
    }

    shape(places, { fill, line, width = 1.5, dash = [], closed = true, opacity = 1 }) {
      const left = this.clipped(places, closed).map((place) => this.pixel(place));
      if (left.length < 2) return;
      const { context } = this;
      context.beginPath();
      left.forEach(([u, v], i) => (i ? context.lineTo(u, v) : context.moveTo(u, v)));
      if (closed) context.closePath();
      context.globalAlpha = opacity;
      if (fill) { context.fillStyle = fill; context.fill(); }
      context.globalAlpha = 1;
      context.setLineDash(dash);
      if (line) { context.strokeStyle = line; context.lineWidth = width; context.stroke(); }
    }

    flat(places, style) {
      this.shape(places.map(([x, y]) => this.seen([x, y, 0])), style);
    }

    // Faces of all boxes, the farthest first.
    boxes(all) {
      all.flatMap(({ box, pose, style }) => {
        const places = corners(box, pose).map((place) => this.seen(place));
        return FACES.map((face) => {
          const own = face.map((i) => places[i]);
          return { own, style, far: own.reduce((sum, place) => sum + place[2], 0) };
        });
      }).sort((one, other) => other.far - one.far)
        .forEach(({ own, style }) => this.shape(own, style));
    }

    cloud(colour) {
      const { context, points: all } = this;
      context.fillStyle = colour;
      for (let i = 0; i < all.length; i += 3) {
        const place = this.seen([all[i], all[i + 1], all[i + 2]]);
        if (place[2] > NEAR) {
          const [u, v] = this.pixel(place);
          context.fillRect(u, v, 1.4, 1.4);
        }
      }
    }

    draw() {
      const { canvas, context, drive, scene, step } = this;
      const [width, height] = [canvas.clientWidth, canvas.clientHeight];
      if (!width) return;
      const ratio = window.devicePixelRatio || 1;
      [canvas.width, canvas.height] = [width * ratio, height * ratio];
      context.setTransform(ratio, 0, 0, ratio, 0, 0);
      this.middle = [width / 2, height / 2];
      this.focal = 0.9 * Math.max(height, 0.6 * width);
      this.angles = [Math.sin(this.turned), Math.cos(this.turned), Math.sin(this.raised), Math.cos(this.raised)];
      const colour = (name) => {
        // Resolved, light or dark: a canvas does not know variables.
        this.probe.style.color = `var(${name})`;
        return getComputedStyle(this.probe).color;
      };
      const at = (box) => box.poses[Math.min(step, box.poses.length - 1)];
      const shown = (name) => this.root.querySelector(`.layer[value="${name}"]`)?.checked ?? false;

      scene.goal.forEach((area) => this.flat(area, { fill: colour("--goal"), opacity: 0.4 }));
      scene.lanes.forEach((lane) => this.flat(lane, { line: colour("--soft"), dash: [9, 7], closed: false, width: 1 }));
      this.flat(drive.planned, { line: colour("--ego"), width: 3, closed: false });
      if (shown("points")) this.cloud(colour("--faint"));
      const all = [];
      if (shown("real")) {
        const style = { fill: colour("--real"), line: colour("--edge"), width: 1, opacity: 0.55 };
        drive.real.forEach((box) => all.push({ box, pose: at(box), style }));
      }
      if (shown("believed")) {
        const style = { line: colour("--believed"), width: 1.6, dash: [5, 3], fill: colour("--believed"), opacity: 0.05 };
        drive.believed.forEach((box) => all.push({ box, pose: at(box), style }));
      }
      const own = { size: scene.vehicle, bottom: 0, poses: drive.car };
      all.push({ box: own, pose: at(own), style: { fill: colour("--ego"), line: colour("--edge"), width: 1, opacity: 0.8 } });
      this.boxes(all);
      this.probe.style.color = "";
      const crashed = drive.outcome === "collision" && step === drive.car.length - 1;
      this.root.querySelector("output").textContent = `${(step * scene.dt).toFixed(1)} s${crashed ? ", collision" : ""}`;
    }
  }

  document.querySelectorAll("details.turn").forEach((root) => {
    root.hidden = false;
    // Nothing is read or drawn before the scene is opened.
    root.addEventListener("toggle", () => { root.turnable ??= new Turnable(root); });
  });
})();
