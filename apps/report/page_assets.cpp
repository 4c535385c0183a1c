// SPDX-License-Identifier: Apache-2.0
#include "apps/report/page_assets.h"

namespace vesta::app {

std::string_view PageStyle() {
  return R"css(
:root { color-scheme: light dark; --back: #fff; --card: #f5f6f8; --line: #dcdfe4; --text: #1c2024; --mute: #646b75;
  --run0: #2563eb; --run1: #d9640b; --run2: #16803c; --run3: #b83280; --run4: #7c4dff; --run5: #6b7280; }
@media (prefers-color-scheme: dark) {
  :root { --back: #14171b; --card: #1d2127; --line: #343a43; --text: #e6e8eb; --mute: #98a1ad;
    --run0: #6ea0ff; --run1: #f4a261; --run2: #57c785; --run3: #f07ab8; --run4: #a98bff; --run5: #a3aab5; }
}
* { box-sizing: border-box; }
body { margin: 0 auto; padding: 24px; max-width: 1280px; background: var(--back); color: var(--text);
  font: 15px/1.5 system-ui, -apple-system, "Segoe UI", Roboto, "DejaVu Sans", sans-serif; }
h1 { font-size: 24px; margin: 0; overflow-wrap: anywhere; }
h2 { font-size: 18px; margin: 36px 0 8px; }
h3 { font-size: 15px; margin: 0 0 6px; overflow-wrap: anywhere; }
p { margin: 4px 0; }
.mute, figcaption { color: var(--mute); font-size: 13px; }
.wide { overflow-x: auto; }
.cards { display: flex; flex-wrap: wrap; gap: 12px; margin: 16px 0; }
.card { background: var(--card); border: 1px solid var(--line); border-radius: 8px; padding: 10px 16px; min-width: 130px; }
.card b { display: block; font-size: 22px; font-weight: 600; font-variant-numeric: tabular-nums; }
table { border-collapse: collapse; font-variant-numeric: tabular-nums; }
th, td { padding: 3px 14px 3px 0; text-align: left; vertical-align: top; border-bottom: 1px solid var(--line); }
th { font-weight: 500; color: var(--mute); }
thead th { color: var(--text); overflow-wrap: anywhere; max-width: 320px; }
td.figure, th.figure { text-align: right; }
tr.differs td { background: var(--card); font-weight: 600; }
ul { margin: 4px 0; padding-left: 20px; }
.key { display: inline-block; width: 12px; height: 12px; border-radius: 3px; margin-right: 6px; }
.grid-of-charts, .grid-of-plans { display: grid; grid-template-columns: repeat(auto-fit, minmax(min(420px, 100%), 1fr)); gap: 12px; }
svg { width: 100%; height: auto; background: var(--card); border: 1px solid var(--line); border-radius: 8px; }
svg text { fill: var(--text); font-size: 12px; }
svg .title { font-weight: 600; font-size: 13px; }
svg .tick { fill: var(--mute); font-size: 11px; }
svg .grid { stroke: var(--line); }
svg polyline { fill: none; stroke: currentColor; stroke-width: 1.8; }
svg circle { fill: currentColor; }
svg .dashed polyline { stroke-dasharray: 5 4; opacity: .75; }
svg .dashed circle { opacity: .6; }
svg .cloud { fill: none; stroke: var(--mute); stroke-width: 2; stroke-linecap: round; opacity: .7; }
svg .camera path { fill: none; stroke: currentColor; stroke-width: 1.4; }
svg .training { color: var(--mute); }
.run0 { color: var(--run0); } .run1 { color: var(--run1); } .run2 { color: var(--run2); }
.run3 { color: var(--run3); } .run4 { color: var(--run4); } .run5 { color: var(--run5); }
.key { background: currentColor; }
article { margin: 14px 0 22px; }
.views { display: grid; grid-template-columns: repeat(auto-fit, minmax(min(480px, 100%), 1fr)); gap: 18px; }
.pair { display: grid; grid-template-columns: repeat(auto-fit, minmax(min(360px, 100%), 1fr)); gap: 12px; }
figure { margin: 0; }
.slide { position: relative; overflow: hidden; border-radius: 6px; border: 1px solid var(--line); background: #000; }
.slide img { position: absolute; inset: 0; width: 100%; height: 100%; }
.slide .render { clip-path: inset(0 calc(100% - var(--at, 50%)) 0 0); }
.slide .error { opacity: 0; image-rendering: auto; }
.show-error .error { opacity: 1; }
.slide::after { content: ""; position: absolute; top: 0; bottom: 0; left: var(--at, 50%); width: 2px; margin-left: -1px;
  background: #fff; box-shadow: 0 0 3px #000; pointer-events: none; }
.show-error .slide::after { display: none; }
.slide input { position: absolute; inset: 0; width: 100%; height: 100%; margin: 0; opacity: 0; cursor: ew-resize; }
.slide:focus-within { outline: 2px solid var(--run0); outline-offset: 1px; }
.scale { display: inline-block; width: 140px; height: 10px; border-radius: 3px; vertical-align: middle;
  background: linear-gradient(90deg, #000004, #420a68, #932667, #dd513a, #fca50a, #fcffa4); }
.bar { display: inline-block; height: 9px; border-radius: 2px; background: currentColor; vertical-align: middle; }
details { margin: 8px 0; } summary { cursor: pointer; }
@media print { .slide input { display: none; } }
)css";
}

std::string_view PageScript() {
  return R"js(
for (const image of document.querySelectorAll("img[data-of]")) image.src = document.getElementById(image.dataset.of).src;
for (const article of document.querySelectorAll("article")) {
  const inputs = article.querySelectorAll(".slide input");
  for (const input of inputs) input.addEventListener("input", () => {
    for (const other of inputs) {
      other.value = input.value;
      other.parentElement.style.setProperty("--at", input.value + "%");
    }
  });
}
const errors = document.getElementById("errors");
if (errors) errors.addEventListener("change", () => document.body.classList.toggle("show-error", errors.checked));
)js";
}

}  // namespace vesta::app
