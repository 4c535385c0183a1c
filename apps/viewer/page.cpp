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
  <canvas id="picture" tabindex="0" aria-label="The splat. Drag to turn, wheel to come nearer, W A S D Q E to fly."></canvas>
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
      <dt>cost</dt><dd id="cost"></dd>
      <dt>PSNR</dt><dd id="psnr"></dd>
    </dl>
    <p id="note" class="mute"></p>
    <div class="buttons">
      <button id="pause">Pause</button>
      <button id="checkpoint">Checkpoint now</button>
      <button id="stop">Stop</button>
    </div>
    <p id="message" class="mute" role="status"></p>
    <figure><figcaption>cost</figcaption><svg id="cost-curve" viewBox="0 0 300 90" preserveAspectRatio="none"></svg><p class="mute range"></p></figure>
    <figure><figcaption>PSNR: <span class="train">training</span>, <span class="test">test</span> views</figcaption><svg id="psnr-curve" viewBox="0 0 300 90" preserveAspectRatio="none"></svg><p class="mute range"></p></figure>
  </section>
  <section>
    <h2>Camera</h2>
    <div class="buttons" role="radiogroup" aria-label="How a drag moves">
      <label><input type="radio" name="drag" value="orbit" checked>orbit</label>
      <label><input type="radio" name="drag" value="fly">fly</label>
      <button id="home">Start</button>
    </div>
    <label>resolution
      <select id="pixels">
        <option value="200000">0.2 megapixels</option>
        <option value="500000" selected>0.5 megapixels</option>
        <option value="1000000">1 megapixel</option>
        <option value="3000000">3 megapixels</option>
      </select></label>
    <p class="mute">Drag turns, with Shift it shifts; the wheel comes nearer. W A S D Q E fly.</p>
  </section>
  <section>
    <h2>Picture</h2>
    <div class="buttons" id="kinds" role="radiogroup" aria-label="What is shown">
      <label><input type="radio" name="kind" value="render" checked>render</label>
      <label><input type="radio" name="kind" value="depth">depth</label>
      <label><input type="radio" name="kind" value="median_depth">median depth</label>
      <label><input type="radio" name="kind" value="normals">normals</label>
      <label><input type="radio" name="kind" value="count">count</label>
      <label class="of-scene"><input type="radio" name="kind" value="worth">worth</label>
      <label class="of-scene"><input type="radio" name="kind" value="support">support</label>
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

}  // namespace vesta::app
