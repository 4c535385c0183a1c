// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/page.h"

namespace vesta::app {

std::string_view ViewerPage() {
  return R"html(<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>vesta</title>
<link rel="icon" href="data:,">
<link rel="stylesheet" href="page.css">
<script src="page.js" defer></script>
</head>
<body>
<main>
  <canvas id="picture" tabindex="0" aria-label="The splat. Drag to orbit, scroll to zoom, W A S D Q E to fly."></canvas>
  <p id="trouble" role="alert" hidden></p>
</main>
<aside>
  <h1>vesta</h1>
  <p id="about" class="mute"></p>
  <section id="training" hidden>
    <h2>Training <span id="status"></span></h2>
    <progress id="done" max="1" value="0"></progress>
    <dl>
      <dt>stage</dt><dd id="stage"></dd>
      <dt>time left</dt><dd id="left"></dd>
      <dt>training loss</dt><dd id="cost"></dd>
      <dt>training PSNR</dt><dd id="psnr"></dd>
    </dl>
    <p id="note" class="mute"></p>
    <div class="buttons">
      <button id="pause">Pause</button>
      <button id="checkpoint">Checkpoint now</button>
      <button id="stop">Stop</button>
    </div>
    <p id="message" class="mute" role="status"></p>
    <figure><figcaption>training loss</figcaption><svg id="cost-curve" viewBox="0 0 300 90" preserveAspectRatio="none"></svg><p class="mute range"></p></figure>
    <figure><figcaption>PSNR: <span class="train">training</span>, <span class="test">test</span> views</figcaption><svg id="psnr-curve" viewBox="0 0 300 90" preserveAspectRatio="none"></svg><p class="mute range"></p></figure>
  </section>
  <section>
    <h2>Camera</h2>
    <div class="buttons" role="radiogroup" aria-label="Effect of dragging">
      <label><input type="radio" name="drag" value="orbit" checked>orbit</label>
      <label><input type="radio" name="drag" value="fly">fly</label>
      <button id="home">Reset</button>
    </div>
    <label>resolution
      <select id="pixels">
        <option value="200000">0.2 megapixels</option>
        <option value="500000" selected>0.5 megapixels</option>
        <option value="1000000">1 megapixel</option>
        <option value="3000000">3 megapixels</option>
      </select></label>
    <p class="mute">Drag: orbit or look around. Shift-drag or right-drag: pan. Wheel: zoom. W A S D Q E: fly.</p>
  </section>
  <section>
    <h2>Display</h2>
    <div class="buttons" id="kinds" role="radiogroup" aria-label="Display mode">
      <label><input type="radio" name="kind" value="render" checked>render</label>
      <label><input type="radio" name="kind" value="depth">depth</label>
      <label><input type="radio" name="kind" value="median_depth">median depth</label>
      <label><input type="radio" name="kind" value="normals">normals</label>
      <label><input type="radio" name="kind" value="count">count</label>
      <label class="of-scene"><input type="radio" name="kind" value="removal_cost">removal cost</label>
      <label class="of-scene"><input type="radio" name="kind" value="coverage">coverage</label>
      <label class="of-photo"><input type="radio" name="kind" value="truth">truth</label>
      <label class="of-photo"><input type="radio" name="kind" value="difference">difference</label>
    </div>
    <p id="kind-note" class="mute"></p>
  </section>
  <section id="photographs" hidden>
    <h2>Photographs</h2>
    <div class="buttons"><button id="previous">&larr;</button><select id="photo" aria-label="Photograph"></select><button id="next">&rarr;</button></div>
  </section>
</aside>
</body>
</html>
)html";
}

std::string ViewerScript() { return std::string(ViewerCameraScript()) + std::string(ViewerPanelScript()); }

std::string_view ViewerStyle() {
  return R"css(
:root { color-scheme: dark; --back: #14171b; --card: #1d2127; --line: #343a43; --text: #e6e8eb; --mute: #98a1ad;
  --train: #6ea0ff; --test: #f4a261; }
* { box-sizing: border-box; }
[hidden] { display: none !important; }
body { margin: 0; height: 100vh; display: flex; background: var(--back); color: var(--text);
  font: 14px/1.45 system-ui, -apple-system, "Segoe UI", Roboto, "DejaVu Sans", sans-serif; }
main { flex: 1; position: relative; min-width: 0; }
canvas { position: absolute; inset: 0; width: 100%; height: 100%; cursor: grab; touch-action: none; outline: none; }
canvas:focus-visible { outline: 2px solid var(--train); outline-offset: -2px; }
canvas.dragged { cursor: grabbing; }
#trouble { position: absolute; left: 16px; bottom: 16px; margin: 0; padding: 8px 14px; border-radius: 6px; background: #7a1f1f; }
aside { width: 320px; padding: 14px 16px; overflow-y: auto; background: var(--card); border-left: 1px solid var(--line); }
h1 { font-size: 18px; margin: 0; }
h2 { font-size: 14px; margin: 18px 0 6px; }
p { margin: 4px 0; overflow-wrap: anywhere; }
.mute, figcaption { color: var(--mute); font-size: 12px; }
.buttons { display: flex; flex-wrap: wrap; gap: 6px; align-items: center; margin: 6px 0; }
button, select { font: inherit; color: inherit; background: var(--back); border: 1px solid var(--line); border-radius: 6px; padding: 4px 10px; }
button:hover:enabled { border-color: var(--mute); } button:disabled { opacity: .4; }
#photo { flex: 1; min-width: 0; }
label { display: inline-flex; gap: 4px; align-items: center; }
label.off { opacity: .4; }
progress { width: 100%; accent-color: var(--train); }
dl { display: grid; grid-template-columns: 100px 1fr; margin: 6px 0; font-variant-numeric: tabular-nums; }
dt { color: var(--mute); } dd { margin: 0; }
figure { margin: 10px 0 0; } figure .range { margin: 0; }
svg { width: 100%; height: 90px; background: var(--back); border: 1px solid var(--line); border-radius: 6px; }
polyline { fill: none; stroke: currentColor; stroke-width: 1.6; vector-effect: non-scaling-stroke; }
.train { color: var(--train); } .test { color: var(--test); }
@media (max-width: 700px) { body { flex-direction: column; } aside { width: auto; max-height: 45vh; border-left: 0; } }
)css";
}

}  // namespace vesta::app
