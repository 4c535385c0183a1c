// SPDX-License-Identifier: Apache-2.0
#include "apps/report/report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "apps/report/error_map.h"
#include "apps/report/page.h"
#include "kernels/core/check.h"
#include "kernels/core/files.h"
#include "kernels/core/profile.h"
#include "kernels/core/schema.h"
#include "problems/gaussian_splatting/model/splat_model.h"
#include "problems/gaussian_splatting/scene/scene.h"

namespace vesta::app {
namespace {

constexpr std::size_t kMostViews = 12;  // views with images
constexpr int kMaxWidth = 1000;         // of an image, pixels

// Sorts a view without a PSNR as the worst.
double Rank(double psnr) { return std::isnan(psnr) ? -INFINITY : psnr; }

std::vector<Index> GaussiansOfDegree(const gs::SplatModel& model) {
  std::vector<Index> counts(static_cast<std::size_t>(model.sh_degree) + 1);
  for (const std::uint8_t degree : gs::StoredDegrees(model)) ++counts[degree];
  return counts;
}

ReportedScene DescribeScene(const std::string& name, const gs::Scene& scene, std::span<const ViewError> errors) {
  ReportedScene described{.scene = name, .points = scene.points.size(), .plans = CameraPlans(scene, errors)};
  bool is_first = true;
  for (const gs::View& view : scene.views) {
    ++(view.is_test() ? described.test : view.is_trained() ? described.training : described.held_out);
    const gs::Camera& camera = view.camera;
    const double angle = gs::HorizontalAngle(camera);
    const auto take = [&](auto value, auto* low, auto* high) {
      *low = is_first ? value : std::min(*low, value);
      *high = is_first ? value : std::max(*high, value);
    };
    take(camera.width, &described.min_width, &described.max_width);
    take(camera.height, &described.min_height, &described.max_height);
    take(angle, &described.min_angle, &described.max_angle);
    is_first = false;
  }
  return described;
}

// Measures a run with its splat and its scene.
void MeasureRun(const PosedSplat& posed, ReportedRun* run, Report* report) {
  run->views = ViewRenderer(*posed.model, *posed.scene).Measure();
  run->gaussians_of_degree = GaussiansOfDegree(*posed.model);
  const std::string& name = run->source.scene;
  const auto is_this = [&](const ReportedScene& scene) { return scene.scene == name; };
  if (std::none_of(report->scenes.begin(), report->scenes.end(), is_this)) {
    report->scenes.push_back(DescribeScene(name, *posed.scene, run->views));
  }
  const auto is_worse = [](const ViewError& a, const ViewError& b) {
    return Rank(a.quality.psnr) < Rank(b.quality.psnr);
  };
  std::stable_sort(run->views.begin(), run->views.end(), is_worse);
}

// The views with the lowest PSNR over the runs.
std::vector<ReportedView> ChooseViews(const std::vector<ReportedRun>& runs, Index* all) {
  struct Ranked {
    double psnr;
    ReportedView view;
  };
  std::vector<Ranked> ranked;
  for (const ReportedRun& run : runs) {
    for (const ViewError& error : run.views) {
      const auto found = std::find_if(ranked.begin(), ranked.end(), [&](const Ranked& other) {
        return other.view.scene == run.source.scene && other.view.name == error.name;
      });
      if (found == ranked.end()) {
        ranked.push_back({Rank(error.quality.psnr), {run.source.scene, error.name, {}}});
      } else {
        found->psnr = std::min(found->psnr, Rank(error.quality.psnr));
      }
    }
  }
  *all = static_cast<Index>(ranked.size());
  std::stable_sort(ranked.begin(), ranked.end(), [](const Ranked& a, const Ranked& b) { return a.psnr < b.psnr; });
  ranked.resize(std::min(ranked.size(), kMostViews));
  std::vector<ReportedView> views;
  views.reserve(ranked.size());
  for (Ranked& one : ranked) views.push_back(std::move(one.view));
  return views;
}

void AddPictures(const PosedSplat& posed, std::size_t run, const std::string& scene, std::vector<ReportedView>* views) {
  ViewRenderer renderer(*posed.model, *posed.scene);
  for (ReportedView& reported : *views) {
    if (reported.scene != scene) continue;
    for (const gs::View& view : posed.scene->views) {
      if (!view.is_test() || view.name != reported.name) continue;
      reported.runs.emplace_back(run, renderer.Picture(view, kMaxWidth));
      // The page has the photograph only once.
      if (reported.runs.size() > 1) reported.runs.back().second.truth.clear();
    }
  }
}

}  // namespace

Report GatherReport(std::vector<RunSource> sources, const SplatLoader& load) {
  Report report;
  for (std::size_t i = 0; i < sources.size(); ++i) {
    ReportedRun run{.source = std::move(sources[i]), .missing = ""};
    try {
      MeasureRun(load(i), &run, &report);
      if (run.views.empty()) run.missing = "the scene has no test views";
    } catch (const Error& error) {
      run.missing = error.what();
    }
    report.runs.push_back(std::move(run));
  }
  report.views = ChooseViews(report.runs, &report.test_views);
  for (std::size_t i = 0; i < report.runs.size(); ++i) {
    const ReportedRun& run = report.runs[i];
    if (run.missing.empty()) AddPictures(load(i), i, run.source.scene, &report.views);
  }
  return report;
}

std::string SceneToReport(const std::string& folder, int downscale) {
  const std::string path = std::filesystem::absolute(folder).lexically_normal().string();
  return downscale == 1 ? path : fmt::format("{}, downscaled by {}", path, downscale);
}

std::vector<std::string> WriteReport(const std::string& file, std::vector<RunSource> runs, const SplatLoader& load) {
  const ScopedPhase phase("report");
  const Report report = GatherReport(std::move(runs), load);
  WriteFileAtomically(file, ReportPage(report));
  std::vector<std::string> missing;
  for (const ReportedRun& run : report.runs) {
    if (run.missing.empty()) continue;
    missing.push_back(
        fmt::format("{}: the report does not show its test views: {}", run.source.record.name(), run.missing));
  }
  return missing;
}

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

RunRecord::RunRecord(std::string name, const std::string& metrics, std::int64_t splat_bytes)
    : name_(std::move(name)), json_(Json::parse(metrics, nullptr, false)), splat_bytes_(splat_bytes) {
  if (!json_.is_object()) Fail(kBadFile, "{}: its metrics.json is not from a training run", name_);
}

const Json* RunRecord::At(const std::string& path) const {
  const Json* at = &json_;
  for (const std::string& key : schema::SplitAt(path, '.')) {
    if (!at->is_object()) return nullptr;
    const auto found = at->find(key);
    if (found == at->end()) return nullptr;
    at = &*found;
  }
  return at;
}

double RunRecord::Number(const std::string& path) const {
  const Json* at = At(path);
  return at && at->is_number() ? at->get<double>() : NAN;
}

std::string RunRecord::Text(const std::string& path) const {
  const Json* at = At(path);
  return at && at->is_string() ? at->get<std::string>() : "";
}

std::vector<std::string> RunRecord::notes() const {
  std::vector<std::string> notes;
  const Json* at = At("notes");
  if (!at || !at->is_array()) return notes;
  for (const Json& note : *at) {
    if (note.is_string()) notes.push_back(note.get<std::string>());
  }
  return notes;
}

std::vector<PhaseRow> RunRecord::phases() const {
  std::vector<PhaseRow> rows;
  const Json* at = At("profile");
  if (!at || !at->is_array()) return rows;
  for (const Json& row : *at) {
    const auto number = [&](const char* key) {
      return row.contains(key) && row[key].is_number() ? row[key].get<double>() : 0;
    };
    if (!row.is_object() || !row.contains("phase") || !row["phase"].is_string()) continue;
    rows.push_back({row["phase"],
                    static_cast<int>(std::clamp(number("depth"), 0.0, 9.0)),
                    static_cast<std::int64_t>(std::clamp(number("calls"), 0.0, 1e15)),
                    {number("wall_seconds"), number("cpu_seconds")}});
  }
  return rows;
}

std::vector<double> RunRecord::History(const char* figure) const {
  std::vector<double> figures;
  const Json* at = At("history");
  if (!at || !at->is_array()) return figures;
  for (const Json& row : *at) {
    const bool is_there = row.is_object() && row.contains(figure) && row[figure].is_number();
    figures.push_back(is_there ? row[figure].get<double>() : NAN);
  }
  return figures;
}

std::vector<std::pair<std::string, std::string>> RunRecord::Options() const {
  const Json* at = At("options");
  return at ? Flattened(*at) : std::vector<std::pair<std::string, std::string>>();
}

RunRecord ReadRun(const std::string& folder) {
  const std::string metrics = (fs::path(folder) / "metrics.json").string();
  std::error_code missing;
  const std::uintmax_t bytes = fs::file_size(fs::path(folder) / "point_cloud.ply", missing);
  return {folder, ReadFile(metrics), missing ? 0 : static_cast<std::int64_t>(bytes)};
}

std::vector<std::pair<std::string, std::string>> Flattened(const Json& object) {
  std::vector<std::pair<std::string, std::string>> flat;
  if (!object.is_object()) return flat;
  for (const auto& [part, values] : object.items()) {
    if (!values.is_object()) continue;
    for (const auto& [key, value] : values.items()) {
      flat.emplace_back(fmt::format("{}.{}", part, key), value.is_string() ? value.get<std::string>() : value.dump());
    }
  }
  return flat;
}

}  // namespace vesta::app
