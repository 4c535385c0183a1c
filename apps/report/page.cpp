// SPDX-License-Identifier: Apache-2.0
#include "apps/report/page.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "apps/cli/print.h"
#include "apps/report/html.h"

namespace vesta::app {
namespace {

std::string Swatch(std::size_t run) { return fmt::format(R"(<span class="key run{}"></span>)", run % kRunColors); }

// "12,345"; "-" if unknown.
std::string Count(double value) {
  if (!std::isfinite(value)) return "-";
  std::string digits = fmt::format("{:.0f}", value);
  for (auto at = static_cast<std::ptrdiff_t>(digits.size()) - 3; at > 0; at -= 3) {
    digits.insert(static_cast<std::size_t>(at), 1, ',');
  }
  return digits;
}

std::string Bytes(double bytes) {
  constexpr double kMib = 1 << 20;
  return bytes > 0 ? fmt::format("{:.{}f} MiB", bytes / kMib, bytes < 10 * kMib ? 2 : 1) : "-";
}

std::string Seconds(double seconds) { return std::isfinite(seconds) ? fmt::format("{:.1f} s", seconds) : "-"; }

std::string TextOr(const std::string& text) { return text.empty() ? "-" : Escape(text); }

// A table row with one value per run.
struct Row {
  const char* name;
  std::function<std::string(const ReportedRun&)> of;  // as HTML
};

std::string Figures(const std::vector<ReportedRun>& runs, const std::vector<Row>& rows) {
  std::string html = R"(<div class="wide"><table><thead><tr><th></th>)";
  for (std::size_t i = 0; i < runs.size(); ++i) {
    html += fmt::format(R"(<th class="figure">{}<bdi>{}</bdi></th>)", Swatch(i), Escape(runs[i].source.record.name()));
  }
  html += "</tr></thead><tbody>\n";
  for (const Row& row : rows) {
    html += fmt::format("<tr><th>{}</th>", row.name);
    for (const ReportedRun& run : runs) html += fmt::format(R"(<td class="figure">{}</td>)", row.of(run));
    html += "</tr>\n";
  }
  return html + "</tbody></table></div>\n";
}

Row Quality(const char* name, const char* path, int digits) {
  return {name, [=](const ReportedRun& run) { return Figure(run.source.record.Number(path), digits); }};
}

// Seconds between two times in metrics.json. from: null for the start.
Row Span(const char* name, const char* from, const char* to) {
  return {name, [=](const ReportedRun& run) {
            const RunRecord& record = run.source.record;
            return Seconds(record.Number(to) - (from ? record.Number(from) : 0));
          }};
}

std::string Result(const Report& report) {
  std::vector<Row> rows = {
      Quality("test PSNR, dB", "test.psnr", 2),
      Quality("test SSIM", "test.ssim", 4),
      Quality("training PSNR, dB", "train.psnr", 2),
      Quality("training SSIM", "train.ssim", 4),
      {"Gaussians", [](const ReportedRun& run) { return Count(run.source.record.Number("gaussians")); }},
      {"Gaussians of SH degree 0, 1, ...",
       [](const ReportedRun& run) {
         std::string counts;
         for (const Index count : run.gaussians_of_degree) {
           counts += fmt::format("{}{}", counts.empty() ? "" : " / ", Count(static_cast<double>(count)));
         }
         return counts.empty() ? "-" : counts;
       }},
      {"parameters", [](const ReportedRun& run) { return Count(run.source.record.Number("parameters")); }},
      {"point_cloud.ply",
       [](const ReportedRun& run) { return Bytes(static_cast<double>(run.source.record.splat_bytes())); }},
      {"peak memory",
       [](const ReportedRun& run) { return Bytes(run.source.record.Number("peak_memory_mib") * (1 << 20)); }},
      {"scene", [](const ReportedRun& run) { return "<bdi>" + TextOr(run.source.record.Text("scene")) + "</bdi>"; }},
      {"command", [](const ReportedRun& run) { return TextOr(run.source.record.Text("command")); }},
      {"preset", [](const ReportedRun& run) { return TextOr(run.source.record.Text("preset")); }},
      {"device", [](const ReportedRun& run) { return TextOr(run.source.record.Text("device")); }},
      {"threads", [](const ReportedRun& run) { return Count(run.source.record.Number("threads")); }},
      {"vesta", [](const ReportedRun& run) { return TextOr(run.source.record.Text("version")); }},
  };
  return Figures(report.runs, rows);
}

std::string Cards(const ReportedRun& run) {
  const RunRecord& record = run.source.record;
  const auto card = [](const std::string& value, const char* what) {
    return fmt::format(R"(<div class="card"><b>{}</b>{}</div>)", value, what);
  };
  return "<div class=\"cards\">" + card(Figure(record.Number("test.psnr"), 2) + " dB", "test PSNR") +
         card(Figure(record.Number("test.ssim"), 3), "test SSIM") +
         card(Count(record.Number("gaussians")), "Gaussians") +
         card(Bytes(static_cast<double>(record.splat_bytes())), "point_cloud.ply") +
         card(Seconds(record.Number("seconds.total")), "total time") + "</div>\n";
}

std::string Notes(const Report& report) {
  std::string items;
  for (std::size_t i = 0; i < report.runs.size(); ++i) {
    const ReportedRun& run = report.runs[i];
    std::vector<std::string> notes = run.source.record.notes();
    if (!run.missing.empty()) notes.push_back("Its test views are not shown: " + run.missing);
    for (const std::string& note : notes) {
      items += fmt::format("<li>{}{}</li>\n", report.runs.size() > 1 ? Swatch(i) : "", Escape(note));
    }
  }
  return items.empty() ? "" : "<h2>Notes</h2>\n<ul>\n" + items + "</ul>\n";
}

// A value over time; with of_training also of the training views, dashed.
std::string Curves(const Report& report, const char* title, const char* figure, const char* of_training = nullptr) {
  Chart chart{title, "seconds", {}};
  const auto add = [&](std::size_t run, const char* of, bool is_dashed) {
    const RunRecord& record = report.runs[run].source.record;
    const std::vector<double> seconds = record.History("seconds"), values = record.History(of);
    Series series{record.name() + (is_dashed ? ", training" : ""), run, is_dashed, {}};
    for (std::size_t i = 0; i < values.size(); ++i) series.points.push_back({seconds[i], values[i]});
    chart.series.push_back(std::move(series));
  };
  for (std::size_t i = 0; i < report.runs.size(); ++i) {
    if (of_training) add(i, of_training, true);
    add(i, figure, false);
  }
  return ToSvg(chart);
}

std::string Course(const Report& report) {
  return "<h2>Progress</h2>\n<p class=\"mute\">Test views: solid; training views: dashed. Time excludes evaluations. "
         "Each "
         "point is a row of the history in metrics.json.</p>\n<div class=\"grid-of-charts\">\n" +
         Curves(report, "PSNR, dB", "test_psnr", "train_psnr") + Curves(report, "SSIM", "test_ssim", "train_ssim") +
         Curves(report, "training loss", "cost") + Curves(report, "Gaussians", "gaussians") + "</div>\n";
}

const ViewError* FindView(const ReportedRun& run, const ReportedView& view) {
  const auto found =
      std::find_if(run.views.begin(), run.views.end(), [&](const ViewError& e) { return e.name == view.name; });
  return found == run.views.end() ? nullptr : &*found;
}

// Image comparison of a view. number: of the view on the page.
std::string Slider(const Report& report, const ReportedView& view, std::size_t number, std::size_t in_view) {
  const auto& [run, pictures] = view.runs[in_view];
  const std::string truth = pictures.truth.empty() ? fmt::format(R"(data-of="truth{}")", number)
                                                   : fmt::format(R"(id="truth{}" src="{}")", number, pictures.truth);
  std::string caption = report.runs.size() > 1 ? fmt::format("{}<bdi>{}</bdi> ", Swatch(run),
                                                             Escape(report.runs[run].source.record.name()))
                                               : "";
  if (const ViewError* error = FindView(report.runs[run], view)) {
    caption +=
        fmt::format("{} dB, SSIM {}; half of the squared error in {:.1f} % of the pixels",
                    Figure(error->quality.psnr, 2), Figure(error->quality.ssim, 3), 100 * error->half_error_fraction);
  }
  return fmt::format(
      R"(<figure><div class="slide" style="aspect-ratio:{}/{}"><img alt="photograph" {}><img class="render" alt="render" src="{}"><img class="error" alt="error" src="{}"><input type="range" min="0" max="100" step="0.5" value="50" aria-label="position of the line: render on the left, photograph on the right"></div><figcaption>{}</figcaption></figure>)"
      "\n",
      pictures.width, pictures.height, truth, pictures.render, pictures.error, caption);
}

std::string Views(const Report& report) {
  if (report.views.empty()) return "";
  std::string html = fmt::format(
      "<h2>Test views, worst first</h2>\n<p class=\"mute\">{} of {}. The render is on the left of the line, the "
      "photograph on the right; drag the line or use the arrow keys.</p>\n<p><label><input type=\"checkbox\" "
      "id=\"errors\"> show the "
      "error</label> <span class=\"mute\">0 <span class=\"scale\"></span> 64 of 255 or more, mean over the "
      "channels</span></p>\n<div class=\"{}\">\n",
      report.views.size(), report.test_views, report.runs.size() > 1 ? "" : "views");
  for (std::size_t i = 0; i < report.views.size(); ++i) {
    const ReportedView& view = report.views[i];
    html += fmt::format("<article><h3><bdi>{}</bdi></h3><div class=\"{}\">\n", Escape(view.name),
                        view.runs.size() > 1 ? "pair" : "");
    for (std::size_t j = 0; j < view.runs.size(); ++j) html += Slider(report, view, i, j);
    html += "</div></article>\n";
  }
  return html + "</div>\n";
}

// Table of all test views of each run.
std::string ViewTable(const Report& report) {
  std::string html;
  for (std::size_t i = 0; i < report.runs.size(); ++i) {
    const ReportedRun& run = report.runs[i];
    if (run.views.empty()) continue;
    html += fmt::format(
        "<details><summary>All test views{}</summary>\n<div class=\"wide\"><table><thead><tr><th>view</th><th "
        "class=\"figure\">PSNR, dB</th><th></th><th class=\"figure\">SSIM</th><th class=\"figure\">half of the error "
        "in</th></tr></thead><tbody>\n",
        report.runs.size() > 1 ? fmt::format(" of {}<bdi>{}</bdi>", Swatch(i), Escape(run.source.record.name())) : "");
    for (const ViewError& view : run.views) {
      const double psnr = view.quality.psnr;
      const double length = std::isfinite(psnr) ? std::clamp(4 * psnr, 0.0, 200.0) : 200;
      html += fmt::format(
          R"(<tr><td><bdi>{}</bdi></td><td class="figure">{}</td><td><span class="bar run{}" style="width:{:.0f}px"></span></td><td class="figure">{}</td><td class="figure">{:.1f} %</td></tr>)"
          "\n",
          Escape(view.name), Figure(psnr, 2), i % kRunColors, length, Figure(view.quality.ssim, 4),
          100 * view.half_error_fraction);
    }
    html += "</tbody></table></div></details>\n";
  }
  return html;
}

template <class T>
std::string FromTo(T low, T high, int digits) {
  const std::string one = fmt::format("{:.{}f}", static_cast<double>(low), digits);
  const std::string other = fmt::format("{:.{}f}", static_cast<double>(high), digits);
  return one == other ? one : one + " to " + other;
}

std::string Cameras(const Report& report) {
  if (report.scenes.empty()) return "";
  std::string html =
      "<h2>Cameras</h2>\n<p class=\"mute\">Training views are grey, test views green (best) to red (worst). The dots "
      "are a sample of the initial points.</p>\n";
  for (const ReportedScene& scene : report.scenes) {
    if (report.scenes.size() > 1) html += fmt::format("<h3><bdi>{}</bdi></h3>", Escape(scene.scene));
    html += fmt::format(
        "<p>{} training views, {}{} test views; {} × {} pixels, horizontal field of view {}°; {} points</p>\n<div "
        "class=\"grid-of-plans\">\n{}</div>\n",
        scene.training, scene.held_out > 0 ? fmt::format("{} held out, ", scene.held_out) : "", scene.test,
        FromTo(scene.min_width, scene.max_width, 0), FromTo(scene.min_height, scene.max_height, 0),
        FromTo(scene.min_angle, scene.max_angle, 1), Count(static_cast<double>(scene.points)), scene.plans);
  }
  return html;
}

// The phases of --profile, each with a bar. run: number of the run.
std::string Phases(const RunRecord& record, std::size_t run) {
  const std::vector<PhaseRow> rows = record.phases();
  if (rows.empty()) return "";
  std::string html = fmt::format(
      "<h3>Phases of {}<bdi>{}</bdi></h3>\n<div class=\"wide\"><table><thead><tr><th>phase</th><th></th><th "
      "class=\"figure\">%</th><th class=\"figure\">wall</th><th class=\"figure\">CPU</th><th "
      "class=\"figure\">calls</th></tr></thead><tbody>\n",
      Swatch(run), Escape(record.name()));
  for (const PhaseRow& row : rows) {
    const double percent = 100 * row.seconds.wall / std::max(rows.front().seconds.wall, 1e-9);
    html += fmt::format(
        R"(<tr><td style="padding-left:{}em">{}</td><td><span class="bar run{}" style="width:{:.0f}px"></span></td><td class="figure">{:.1f}</td><td class="figure">{}</td><td class="figure">{}</td><td class="figure">{}</td></tr>)"
        "\n",
        2 * std::clamp(row.depth, 0, 9), Escape(row.name), run % kRunColors, std::clamp(2 * percent, 0.0, 200.0),
        percent, Seconds(row.seconds.wall), Seconds(row.seconds.cpu),
        row.calls > 0 ? Count(static_cast<double>(row.calls)) : "");
  }
  return html + "</tbody></table></div>\n";
}

std::string Times(const Report& report) {
  const std::vector<Row> rows = {Span("loading", nullptr, "seconds.load"),
                                 Span("Adam", "seconds.load", "seconds.adam_end"),
                                 Span("Levenberg-Marquardt", "seconds.adam_end", "seconds.lm_end"),
                                 Span("evaluations", nullptr, "seconds.eval"), Span("total", nullptr, "seconds.total")};
  std::string html = "<h2>Times</h2>\n" + Figures(report.runs, rows);
  for (std::size_t i = 0; i < report.runs.size(); ++i) html += Phases(report.runs[i].source.record, i);
  return html;
}

std::string Title(const Report& report) {
  return report.runs.size() == 1 ? Escape(report.runs[0].source.record.name())
                                 : fmt::format("{} training runs", report.runs.size());
}

}  // namespace

std::string ReportPage(const Report& report) {
  std::string html = "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n";
  html +=
      "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; img-src data:; style-src "
      "'unsafe-inline'; script-src 'unsafe-inline'\">\n<meta name=\"viewport\" content=\"width=device-width, "
      "initial-scale=1\">\n<link rel=\"icon\" href=\"data:,\">\n";
  html += fmt::format("<title>{}: vesta</title>\n<style>{}</style>\n</head>\n<body>\n", Title(report), PageStyle());
  html += fmt::format("<header><h1>{}</h1></header>\n", Title(report));
  if (report.runs.size() == 1) html += Cards(report.runs[0]);
  html += Notes(report);
  html += "<h2>Result</h2>\n" + Result(report);
  html += Course(report);
  html += Views(report);
  html += ViewTable(report);
  html += Cameras(report);
  html += Times(report);
  html += SettingsTable(report);
  html += fmt::format("<script>{}</script>\n</body>\n</html>\n", PageScript());
  return html;
}

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
