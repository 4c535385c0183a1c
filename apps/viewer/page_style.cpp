// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/page.h"

namespace vesta::app {

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
dl { display: grid; grid-template-columns: 80px 1fr; margin: 6px 0; font-variant-numeric: tabular-nums; }
dt { color: var(--mute); } dd { margin: 0; }
figure { margin: 10px 0 0; } figure .range { margin: 0; }
svg { width: 100%; height: 90px; background: var(--back); border: 1px solid var(--line); border-radius: 6px; }
polyline { fill: none; stroke: currentColor; stroke-width: 1.6; vector-effect: non-scaling-stroke; }
.train { color: var(--train); } .test { color: var(--test); }
@media (max-width: 700px) { body { flex-direction: column; } aside { width: auto; max-height: 45vh; border-left: 0; } }
)css";
}

}  // namespace vesta::app
