"""The 3D animation of the report: a script of our own, so that the page opens without a network.

It draws on a plain 2D canvas: faces are turned, shaded and painted from back to front, which for
some hundred faces is fast enough anywhere and needs no library.
"""

from __future__ import annotations

SCRIPT = r"""
"use strict";
const floats = (text) => new Float32Array(Uint8Array.from(atob(text), (c) => c.charCodeAt(0)).buffer);
const SIDES = {left: "#0072B2", right: "#D55E00"};
const LIGHT = [0.35, -0.45, 0.82];
const ROUND = 10;  // sides of a cylinder

// Faces of a shape in its own frame, corners counter-clockwise seen from outside.
function facesOf(shape) {
  const [a, b, c] = shape.size;
  if (shape.kind === "box") {
    const corner = (i) => [(i & 1 ? a : -a) / 2, (i & 2 ? b : -b) / 2, (i & 4 ? c : -c) / 2];
    return [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]]
      .map((face) => face.map(corner));
  }
  if (shape.kind !== "cylinder") return [];
  const ring = (z) => Array.from({length: ROUND}, (_, i) => {
    const angle = 2 * Math.PI * i / ROUND;
    return [a * Math.cos(angle), a * Math.sin(angle), z];
  });
  const low = ring(-b / 2), high = ring(b / 2);
  const sides = low.map((p, i) => [p, low[(i + 1) % ROUND], high[(i + 1) % ROUND], high[i]]);
  return [...sides, high, [...low].reverse()];
}

function turn(m, v) {
  return [m[0] * v[0] + m[1] * v[1] + m[2] * v[2], m[3] * v[0] + m[4] * v[1] + m[5] * v[2],
          m[6] * v[0] + m[7] * v[1] + m[8] * v[2]];
}
const add = (a, b) => [a[0] + b[0], a[1] + b[1], a[2] + b[2]];

// Rotation matrix of a quaternion x, y, z, w.
function matrix(x, y, z, w) {
  return [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w),
          2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w),
          2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)];
}

function normalOf(face) {
  const u = [0, 1, 2].map((i) => face[1][i] - face[0][i]), v = [0, 1, 2].map((i) => face[2][i] - face[1][i]);
  const n = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
  const length = Math.hypot(...n) || 1;
  return n.map((part) => part / length);
}

class Run {
  constructor(data) {
    Object.assign(this, data);
    for (const name of ["poses", "base", "zmp", "com", "forces"]) this[name] = floats(data[name]);
    for (const shape of this.shapes) {
      const place = (v) => add(turn(shape.rotation, v), shape.position);
      shape.faces = facesOf(shape).map((face) => face.map(place));
    }
  }
  time(frame) { return this.start + frame * this.step; }
  place(frame, link) {
    const p = this.poses.subarray((frame * this.links + link) * 7, (frame * this.links + link + 1) * 7);
    return {position: [p[0], p[1], p[2]], rotation: matrix(p[3], p[4], p[5], p[6])};
  }
}

class Player {
  constructor(root, runs) {
    this.runs = runs.map((data) => new Run(data));
    this.canvas = root.querySelector("canvas");
    this.pen = this.canvas.getContext("2d");
    this.slider = root.querySelector("input[type=range]");
    this.button = root.querySelector("button");
    this.clock = root.querySelector("output");
    this.speed = root.querySelector("select.speed");
    this.yaw = -1.0; this.pitch = 0.22; this.distance = 3.6;
    this.playing = false; this.last = 0; this.frame = 0;
    this.choose(0);
    const chooser = root.querySelector("select.run");
    if (chooser) chooser.addEventListener("change", () => this.choose(Number(chooser.value)));
    this.button.addEventListener("click", () => this.play(!this.playing));
    this.slider.addEventListener("input", () => { this.frame = Number(this.slider.value); this.draw(); });
    this.listenToHand();
    this.draw();
  }
  choose(index) {
    this.run = this.runs[index];
    this.slider.max = String(this.run.frames - 1);
    this.frame = Math.min(this.frame, this.run.frames - 1);
    this.draw();
  }
  listenToHand() {
    let held = null;
    this.canvas.addEventListener("pointerdown", (e) => {
      held = [e.clientX, e.clientY]; this.canvas.setPointerCapture(e.pointerId);
    });
    this.canvas.addEventListener("pointerup", () => { held = null; });
    this.canvas.addEventListener("pointermove", (e) => {
      if (!held) return;
      this.yaw -= (e.clientX - held[0]) * 0.008;
      this.pitch = Math.min(1.5, Math.max(-0.05, this.pitch + (e.clientY - held[1]) * 0.006));
      held = [e.clientX, e.clientY];
      this.draw();
    });
    this.canvas.addEventListener("wheel", (e) => {
      e.preventDefault();
      this.distance = Math.min(15, Math.max(1.2, this.distance * Math.exp(e.deltaY * 0.001)));
      this.draw();
    }, {passive: false});
  }
  play(on) {
    this.playing = on;
    this.button.textContent = on ? "Pause" : "Play";
    if (on && this.frame >= this.run.frames - 1) this.frame = 0;
    this.last = 0;
    if (on) requestAnimationFrame((now) => this.advance(now));
  }
  advance(now) {
    if (!this.playing) return;
    if (this.last) this.frame += (now - this.last) / 1000 / this.run.step * Number(this.speed.value);
    this.last = now;
    if (this.frame >= this.run.frames - 1) { this.frame = this.run.frames - 1; this.play(false); }
    this.draw();
    if (this.playing) requestAnimationFrame((then) => this.advance(then));
  }
  look(frame) {
    const base = this.run.base.subarray(3 * frame, 3 * frame + 3);
    const target = [base[0], base[1], 0.75];
    const cy = Math.cos(this.yaw), sy = Math.sin(this.yaw);
    const cp = Math.cos(this.pitch), sp = Math.sin(this.pitch);
    // Rows: to the right, up, towards the eye.
    this.eye = [-sy, cy, 0, -sp * cy, -sp * sy, cp, cp * cy, cp * sy, sp];
    this.target = target;
    this.scale = 1.15 * Math.min(this.canvas.width, 1.4 * this.canvas.height);
  }
  // Place on the canvas and distance from the eye.
  project(v) {
    const t = turn(this.eye, [v[0] - this.target[0], v[1] - this.target[1], v[2] - this.target[2]]);
    const depth = Math.max(this.distance - t[2], 0.05);
    const x = this.canvas.width / 2 + this.scale * t[0] / depth;
    return [x, this.canvas.height / 2 - this.scale * t[1] / depth, depth];
  }
  line(a, b, color, width) {
    const p = this.project(a), q = this.project(b);
    if (p[2] <= 0.06 || q[2] <= 0.06) return;
    this.pen.strokeStyle = color; this.pen.lineWidth = width;
    this.pen.beginPath(); this.pen.moveTo(p[0], p[1]); this.pen.lineTo(q[0], q[1]); this.pen.stroke();
  }
  polygon(points, fill, stroke) {
    this.pen.beginPath();
    points.forEach((p, i) => (i ? this.pen.lineTo(p[0], p[1]) : this.pen.moveTo(p[0], p[1])));
    this.pen.closePath();
    if (fill) { this.pen.fillStyle = fill; this.pen.fill(); }
    if (stroke) { this.pen.strokeStyle = stroke; this.pen.lineWidth = 1; this.pen.stroke(); }
  }
  disc(v, radius, color) {
    const p = this.project(v);
    this.pen.fillStyle = color;
    this.pen.beginPath(); this.pen.arc(p[0], p[1], radius, 0, 2 * Math.PI); this.pen.fill();
  }
  ground(frame) {
    const x0 = Math.round(this.target[0] * 2) / 2, y0 = Math.round(this.target[1] * 2) / 2;
    for (let i = -6; i <= 6; i += 1) {
      this.line([x0 + i / 2, y0 - 3, 0], [x0 + i / 2, y0 + 3, 0], "#dddddd", 1);
      this.line([x0 - 3, y0 + i / 2, 0], [x0 + 3, y0 + i / 2, 0], "#dddddd", 1);
    }
    const time = this.run.time(frame);
    for (const print of this.run.prints) {
      if (print.from > time) continue;
      this.polygon(print.corners.map((c) => this.project([c[0], c[1], 0])), null, SIDES[print.side]);
    }
    for (const [name, color] of [["com", "#009E73"], ["zmp", "#CC3377"]]) {
      const x = this.run[name][2 * frame], y = this.run[name][2 * frame + 1];
      if (Number.isFinite(x)) this.disc([x, y, 0], 5, color);
    }
  }
  shade(color, normal) {
    const facing = normal[0] * LIGHT[0] + normal[1] * LIGHT[1] + normal[2] * LIGHT[2];
    const light = 0.62 + 0.38 * Math.max(0, facing);
    return "rgb(" + color.map((part) => Math.round(part * light)).join(",") + ")";
  }
  body(frame) {
    const jobs = [];
    for (const shape of this.run.shapes) {
      const place = this.run.place(frame, shape.link);
      const world = (v) => add(turn(place.rotation, v), place.position);
      if (shape.kind === "sphere") {
        const middle = this.project(world(shape.position));
        const radius = this.scale * shape.size[0] / middle[2];
        jobs.push({depth: middle[2], paint: () => this.ball(middle, radius, shape.color)});
      }
      for (const face of shape.faces) {
        const corners = face.map(world), seen = corners.map((v) => this.project(v));
        let area = 0;
        seen.forEach((p, i) => {
          const q = seen[(i + 1) % seen.length];
          area += p[0] * q[1] - q[0] * p[1];
        });
        if (area >= 0) continue;  // seen from behind: the canvas counts y downwards
        const depth = seen.reduce((sum, p) => sum + p[2], 0) / seen.length;
        const color = this.shade(shape.color, normalOf(corners));
        jobs.push({depth, paint: () => this.polygon(seen, color, color)});
      }
    }
    jobs.sort((a, b) => b.depth - a.depth);
    for (const job of jobs) job.paint();
  }
  ball(middle, radius, color) {
    const glow = this.pen.createRadialGradient(middle[0] - radius / 3, middle[1] - radius / 3, radius / 5,
                                               middle[0], middle[1], radius);
    glow.addColorStop(0, "rgb(" + color.join(",") + ")");
    glow.addColorStop(1, "rgb(" + color.map((part) => Math.round(0.62 * part)).join(",") + ")");
    this.pen.fillStyle = glow;
    this.pen.beginPath(); this.pen.arc(middle[0], middle[1], radius, 0, 2 * Math.PI); this.pen.fill();
  }
  hands(frame) {
    for (let hand = 0; hand < 2; hand += 1) {
      const v = this.run.forces.subarray((2 * frame + hand) * 6, (2 * frame + hand + 1) * 6);
      if (!v.every(Number.isFinite) || Math.hypot(v[3], v[4], v[5]) < 0.05) continue;
      const tip = [v[0] + 0.05 * v[3], v[1] + 0.05 * v[4], v[2] + 0.05 * v[5]];
      this.line([v[0], v[1], v[2]], tip, "#E69F00", 3);
      this.disc(tip, 4, "#E69F00");
    }
  }
  draw() {
    const frame = Math.min(Math.round(this.frame), this.run.frames - 1);
    this.look(frame);
    this.pen.clearRect(0, 0, this.canvas.width, this.canvas.height);
    this.ground(frame);
    this.body(frame);
    this.hands(frame);
    this.slider.value = String(frame);
    this.clock.textContent = this.run.time(frame).toFixed(2) + " s";
  }
}

if (typeof document !== "undefined") {
  const data = JSON.parse(document.getElementById("runs").textContent);
  new Player(document.getElementById("player"), data);
}
"""
