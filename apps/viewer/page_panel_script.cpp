// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/page.h"

namespace vesta::app {

std::string_view ViewerPanelScript() {
  return R"js(
const kindNotes = { render: "", truth: "The photograph.",
  difference: "Where the render differs from the photograph: black where it does not, palest from a quarter of the range of a colour.",
  depth: "From near, yellow, to far, violet: the mean of what a pixel shows.",
  median_depth: "From near, yellow, to far, violet: where half of the light is gone.",
  normals: "Which way surfaces face: light blue faces the camera, red to the right, green up.",
  count: "How many Gaussians each tile of 16 by 16 pixels takes: palest from 1000 on.",
  worth: "By how much the cost of the training views rises without a Gaussian: violet, not at all; teal, as for most; yellow, far more.",
  support: "How much of a Gaussian the training views show, together: violet, hardly any of it; teal, as much as all of it once; yellow, many times that." };

// After the camera has moved, or what is shown has changed.
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
// lines: for each its class and points (x, y).
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
  by("pause").textContent = state.status === "paused" ? "Go on" : "Pause";
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

// How a training goes, and its model where that is newer than the picture. A hidden page does not ask: then no model
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
// Photographs' cameras where they stand now; who looks through one goes along.
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
