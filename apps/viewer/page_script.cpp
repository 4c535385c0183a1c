// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/page.h"

namespace vesta::app {

std::string_view ViewerCameraScript() {
  return R"js("use strict";
const by = id => document.getElementById(id);
const token = new URLSearchParams(location.search).get("token");

// Returns the reply of the server; throws if it failed or is not ready yet (202).
async function ask(path, method = "GET") {
  const response = await fetch(path, { method, headers: { "X-Vesta-Token": token }, cache: "no-store" });
  if (response.status !== 200) throw new Error((await response.text()).trim());
  return response;
}
function tell(trouble) {
  by("trouble").hidden = !trouble;
  by("trouble").textContent = trouble || "";
}

// Quaternions w, x, y, z; vectors of three.
const product = (a, b) => [a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
  a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2], a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1],
  a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0]];
const turn = (q, v) => product(product(q, [0, ...v]), [q[0], -q[1], -q[2], -q[3]]).slice(1);
const about = (axis, angle) => [Math.cos(angle / 2), ...axis.map(x => x * Math.sin(angle / 2))];
const add = (a, b, factor = 1) => a.map((x, i) => x + factor * b[i]);
const length = v => Math.hypot(...v);
const unit = v => v.map(x => x / (length(v) || 1));

let scene = null;                                       // the reply of /scene
let camera = { position: [0, 0, 0], rotation: [1, 0, 0, 0], focal: 1 };  // axes: x right, y down, z forward
let photo = null;                                       // index of the photograph whose camera is used
const canvas = by("picture"), drawing = canvas.getContext("2d");

// The initial camera: the first photograph, or a distant view with the scene upright.
function start() {
  if (scene.views.length) return jump(0);
  const forward = Math.abs(scene.up[2]) < 0.9 ? [0, 0, 1] : [0, 1, 0];
  const up = unit(scene.up), down = up.map(x => -x);
  const dot = forward[0] * up[0] + forward[1] * up[1] + forward[2] * up[2];
  const z = unit(add(forward, up, -dot));
  const x = [down[1] * z[2] - down[2] * z[1], down[2] * z[0] - down[0] * z[2], down[0] * z[1] - down[1] * z[0]];
  place({ position: add(scene.pivot, z, -3 * scene.radius), rotation: fromAxes(x, down, z), focal: 1 });
}
// Quaternion of a rotation with these columns.
function fromAxes(x, y, z) {
  const w = Math.sqrt(Math.max(0, 1 + x[0] + y[1] + z[2])) / 2;
  if (w > 1e-3) return [w, (y[2] - z[1]) / (4 * w), (z[0] - x[2]) / (4 * w), (x[1] - y[0]) / (4 * w)];
  const sides = [x[0], y[1], z[2]], i = sides.indexOf(Math.max(...sides)), axes = [x, y, z], j = (i + 1) % 3, k = (i + 2) % 3;
  const q = [0, 0, 0, 0], s = Math.sqrt(Math.max(1e-12, 1 + axes[i][i] - axes[j][j] - axes[k][k])) * 2;
  q[0] = (axes[j][k] - axes[k][j]) / s, q[1 + i] = s / 4, q[1 + j] = (axes[j][i] + axes[i][j]) / s, q[1 + k] = (axes[k][i] + axes[i][k]) / s;
  return q;
}
function place(to) {
  camera = to;
  photo = null;
  if (kind() === "truth" || kind() === "difference") document.querySelector("[name=kind][value=render]").checked = true;
  moved();
}
function cameraOf(view) {
  const { position, rotation, focal } = scene.views[view];
  return { position, rotation, focal };
}
function jump(to) {
  camera = cameraOf(to);
  photo = to;
  moved();
}

const kind = () => document.querySelector("[name=kind]:checked").value;
const drags = () => document.querySelector("[name=drag]:checked").value;

// While the camera moves, share lowers the number of pixels to keep the frame rate.
let share = 0.5, still = true, stillTimer = 0;
function moved() {
  still = false;
  clearTimeout(stillTimer);
  stillTimer = setTimeout(() => { still = true; draw(); }, 180);
  panelFollows();
  draw();
}
function pictureSize() {
  const room = { width: canvas.clientWidth, height: canvas.clientHeight }, of = photo === null ? room : scene.views[photo];
  const most = Number(by("pixels").value) * (still ? 1 : share);
  const fits = devicePixelRatio * Math.min(room.width / of.width, room.height / of.height);
  const scale = Math.min(Math.sqrt(most / (of.width * of.height)), fits);
  const side = x => Math.max(16, Math.min(4096, Math.round(x * scale)));
  return [side(of.width), side(of.height)];
}
function frameQuery() {
  const [width, height] = pictureSize(), query = new URLSearchParams({ kind: kind(), width, height });
  if (photo !== null) query.set("photo", photo);
  else {
    query.set("position", camera.position.join());
    query.set("rotation", camera.rotation.join());
    query.set("focal", camera.focal);
  }
  return query;
}

let drawn = { version: -1, frames: 0 }, isDrawing = false, isStale = false;
async function draw() {
  isStale = true;
  if (isDrawing || !scene) return;
  isDrawing = true;
  while (isStale) {
    isStale = false;
    const begin = performance.now(), isLow = !still;
    try {
      const response = await ask("frame?" + frameQuery());
      const picture = await createImageBitmap(await response.blob());
      show(picture);
      drawn = { version: Number(response.headers.get("X-Vesta-Version")), frames: drawn.frames + 1 };
      tell("");
    } catch (error) {
      tell(error.message);
      drawn.version = -1;  // requests the image again
    }
    const took = performance.now() - begin;  // target: 40 ms
    if (isLow) share = Math.max(0.02, Math.min(1, share * Math.max(0.5, Math.min(1.3, 40 / took))));
  }
  isDrawing = false;
}
// Draws the complete image, scaled to fit.
function show(picture) {
  canvas.width = canvas.clientWidth * devicePixelRatio, canvas.height = canvas.clientHeight * devicePixelRatio;
  const scale = Math.min(canvas.width / picture.width, canvas.height / picture.height);
  const width = scale * picture.width, height = scale * picture.height;
  drawing.drawImage(picture, (canvas.width - width) / 2, (canvas.height - height) / 2, width, height);
  picture.close();
}

// The distance at which a panned object follows the pointer.
const distance = () => Math.max(0.05 * scene.radius, length(add(scene.pivot, camera.position, -1)));
function dragged(right, down, shifts) {
  const { position, rotation, focal } = camera, height = canvas.clientHeight;
  if (shifts) {
    const step = turn(rotation, [-right, -down, 0]), factor = distance() / (focal * height);
    return place({ ...camera, position: add(position, step, factor) });
  }
  const isOrbit = drags() === "orbit", angle = (isOrbit ? Math.PI : 1 / focal) / height, sign = isOrbit ? 1 : -1;
  const side = turn(rotation, [1, 0, 0]);
  const q = product(about(scene.up, -sign * right * angle), about(side, -sign * down * angle));
  const moves = isOrbit ? add(scene.pivot, turn(q, add(position, scene.pivot, -1))) : position;
  place({ ...camera, position: moves, rotation: product(q, rotation) });
}
function fly(along, seconds) {
  const speed = 0.6 * scene.radius * seconds;
  place({ ...camera, position: add(camera.position, turn(camera.rotation, along), speed) });
}

let held = null;
canvas.addEventListener("pointerdown", event => {
  held = [event.clientX, event.clientY];
  canvas.setPointerCapture(event.pointerId);
  canvas.classList.add("dragged");
});
canvas.addEventListener("pointermove", event => {
  if (!held || !scene) return;
  dragged(event.clientX - held[0], event.clientY - held[1], event.shiftKey || (event.buttons & 6) !== 0);
  held = [event.clientX, event.clientY];
});
for (const name of ["pointerup", "pointercancel"]) canvas.addEventListener(name, () => {
  held = null;
  canvas.classList.remove("dragged");
});
canvas.addEventListener("contextmenu", event => event.preventDefault());
canvas.addEventListener("wheel", event => {
  event.preventDefault();
  if (!scene) return;
  const step = Math.sign(event.deltaY) * -0.1 * distance();
  place({ ...camera, position: add(camera.position, turn(camera.rotation, [0, 0, 1]), step) });
}, { passive: false });

const ways = { w: [0, 0, 1], s: [0, 0, -1], a: [-1, 0, 0], d: [1, 0, 0], q: [0, 1, 0], e: [0, -1, 0] };
const pressed = new Set();
let lastStep = 0;
function step(now) {
  const along = [...pressed].map(key => ways[key]).reduce((a, b) => add(a, b), [0, 0, 0]);
  if (pressed.size && scene) fly(along, Math.min(0.1, (now - lastStep) / 1000));
  lastStep = now;
  if (pressed.size) requestAnimationFrame(step);
}
addEventListener("keydown", event => {
  const key = event.key.toLowerCase();
  if (!ways[key] || event.ctrlKey || event.metaKey || event.altKey || event.target.tagName === "SELECT") return;
  if (!pressed.size) lastStep = performance.now(), requestAnimationFrame(step);
  pressed.add(key);
});
addEventListener("keyup", event => pressed.delete(event.key.toLowerCase()));
addEventListener("blur", () => pressed.clear());
addEventListener("resize", () => draw());
)js";
}

std::string_view ViewerPanelScript() {
  return R"js(
const kindNotes = { render: "", truth: "The photograph.",
  difference: "Difference between render and photograph. Black: none; pale yellow: 25 % of the colour range or more.",
  depth: "Mean depth of each pixel. Yellow: near; violet: far.",
  median_depth: "Depth at which half of the light is absorbed. Yellow: near; violet: far.",
  normals: "Surface normals. Light blue: towards the camera; red: to the right; green: up.",
  count: "Gaussians per tile of 16 x 16 pixels. Pale yellow: 1000 or more.",
  removal_cost: "Rise of the training loss without each Gaussian. Violet: none; teal: the median of the others; yellow: far more.",
  coverage: "How much of each Gaussian the training views show in total. Violet: hardly any; teal: one complete view; yellow: far more." };

// Call after the camera or the display mode has changed.
function panelFollows() {
  by("photo").value = photo === null ? "" : photo;
  for (const label of document.querySelectorAll(".of-photo")) {
    label.classList.toggle("off", photo === null);
    label.firstChild.disabled = photo === null;
  }
  by("kind-note").textContent = kindNotes[kind()];
}
function listPhotographs() {
  by("photographs").hidden = scene.views.length === 0;
  for (const label of document.querySelectorAll(".of-scene")) label.hidden = scene.views.length === 0;
  by("photo").append(new Option("", ""));
  scene.views.forEach((view, i) => by("photo").append(new Option(view.name + (view.role === "train" ? "" : " (" + view.role.replace("_", " ") + ")"), i)));
  by("photo").firstChild.hidden = true;
}
const nextPhoto = by_ => {
  const count = scene.views.length;
  jump(photo === null ? 0 : (photo + by_ + count) % count);
};
by("photo").addEventListener("change", event => jump(Number(event.target.value)));
by("previous").addEventListener("click", () => nextPhoto(-1));
by("next").addEventListener("click", () => nextPhoto(1));
by("home").addEventListener("click", start);
by("pixels").addEventListener("change", () => draw());
for (const input of document.querySelectorAll("[name=kind]")) input.addEventListener("change", () => { panelFollows(); draw(); });

const duration = seconds => {
  if (seconds === null) return "";
  const whole = Math.round(seconds), two = x => String(x).padStart(2, "0");
  return whole < 3600 ? Math.floor(whole / 60) + ":" + two(whole % 60) : Math.floor(whole / 3600) + ":" + two(Math.floor(whole / 60) % 60) + ":" + two(whole % 60);
};
const svgName = "http://www.w3.org/2000/svg";
// lines: a class name and points (x, y) for each.
function plot(svg, lines, unit) {
  const points = lines.flatMap(line => line.points), xs = points.map(p => p[0]), ys = points.map(p => p[1]);
  if (points.length < 2) return;
  const [x0, x1, y0, y1] = [Math.min(...xs), Math.max(...xs), Math.min(...ys), Math.max(...ys)];
  svg.replaceChildren(...lines.map(line => {
    const polyline = document.createElementNS(svgName, "polyline");
    polyline.setAttribute("class", line.name);
    polyline.setAttribute("points", line.points.map(p =>
      (300 * (p[0] - x0) / (x1 - x0 || 1)).toFixed(1) + "," + (85 - 80 * (p[1] - y0) / (y1 - y0 || 1)).toFixed(1)).join(" "));
    return polyline;
  }));
  svg.nextElementSibling.textContent = `${y0.toPrecision(4)} to ${y1.toPrecision(4)}${unit} in ${duration(x1 - x0)}`;
}

let training = null;
function showTraining(state) {
  training = state;
  by("training").hidden = !state;
  if (!state) return;
  by("status").textContent = state.status === "running" ? "" : "(" + state.status + ")";
  by("done").value = state.iterations ? state.iteration / state.iterations : 0;
  by("stage").textContent = state.iterations ? `${state.stage}, ${state.iteration} of ${state.iterations}` : "loading";
  by("left").textContent = duration(state.seconds_left);
  by("cost").textContent = state.cost.toFixed(5);
  by("psnr").textContent = state.psnr > 0 ? state.psnr.toFixed(2) + " dB" : "";
  by("note").textContent = state.note;
  by("message").textContent = state.message;
  by("pause").textContent = state.status === "paused" ? "Resume" : "Pause";
  const isOver = state.status === "stopping" || state.status === "over";
  for (const id of ["pause", "stop", "checkpoint"]) by(id).disabled = isOver;
  plot(by("cost-curve"), [{ name: "train", points: state.costs }], "");
  plot(by("psnr-curve"), [{ name: "train", points: state.train_psnr }, { name: "test", points: state.test_psnr }], " dB");
}
async function command(name) {
  try {
    await ask(name, "POST");
    await follow();
  } catch (error) {
    tell(error.message);
  }
}
by("pause").addEventListener("click", () => command(training.status === "paused" ? "resume" : "pause"));
by("checkpoint").addEventListener("click", () => command("checkpoint"));
by("stop").addEventListener("click", () => command("stop"));

// Updates the state of a training, and the image if the model is newer. A hidden page sends no requests, so that no model
// is copied for it.
async function follow() {
  if (document.hidden) return;
  const state = await (await ask("state")).json();
  by("about").textContent = state.gaussians.toLocaleString("en") + " Gaussians";
  showTraining(state.training);
  if (scene === null && state.version > 0) {
    scene = await (await ask("scene")).json();
    listPhotographs();
    start();
  } else if (state.version !== drawn.version && still) {
    if (state.cameras_move) await followCameras();
    draw();
  }
}
// Updates the cameras of the photographs, and the current camera if it is one of them.
async function followCameras() {
  scene.views = (await (await ask("scene")).json()).views;
  if (photo !== null) camera = cameraOf(photo);
}
async function followAlways() {
  try {
    await follow();
  } catch (error) {
    tell(training && training.status !== "running" ? "The training is over." : "vesta does not answer: " + error.message);
  }
  setTimeout(followAlways, training ? 500 : 2000);
}
document.addEventListener("visibilitychange", () => { if (!document.hidden) follow().catch(() => {}); });
followAlways();
)js";
}

}  // namespace vesta::app
