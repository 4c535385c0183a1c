// SPDX-License-Identifier: Apache-2.0
// The report of finished trainings: reads their records and writes report.html, a self-contained page.
#pragma once

#include <cstdint>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "apps/report/error_map.h"
#include "kernels/core/profile.h"

namespace vesta::app {

// The metrics.json of a finished training. It may come from another version or be written by hand, so a missing key or
// another type means "unknown", not an error.
class RunRecord {
 public:
  // name: of the run; metrics: the text of its metrics.json. Throws Error (one line with the name) if that is not a
  // JSON object.
  RunRecord(std::string name, const std::string& metrics, std::int64_t splat_bytes);

  const std::string& name() const { return name_; }
  std::int64_t splat_bytes() const { return splat_bytes_; }  // size of point_cloud.ply; 0: missing
  // The value at a path of keys such as "seconds.total"; NaN or "" if it is missing.
  double Number(const std::string& path) const;
  std::string Text(const std::string& path) const;
  std::vector<std::string> notes() const;
  std::vector<PhaseRow> phases() const;  // with --profile
  // One value, such as "test_psnr", of each row of the history; NaN if missing.
  std::vector<double> History(const char* figure) const;
  // All options, such as "adam.iterations", as text.
  std::vector<std::pair<std::string, std::string>> Options() const;
  const nlohmann::ordered_json& json() const { return json_; }

 private:
  const nlohmann::ordered_json* At(const std::string& path) const;  // null: missing

  std::string name_;
  nlohmann::ordered_json json_;
  std::int64_t splat_bytes_;
};

// Reads DIR/metrics.json and the size of DIR/point_cloud.ply. Throws Error if the first cannot be read.
RunRecord ReadRun(const std::string& folder);

// The values of an object of objects as texts with names "part.key".
std::vector<std::pair<std::string, std::string>> Flattened(const nlohmann::ordered_json& object);

// A run to report. scene: a text that is equal only for runs on the same photographs at the same size.
struct RunSource {
  RunRecord record;
  std::string scene;
};

// A splat in the frame of its scene, and the scene with at least the images of its test views.
struct PosedSplat {
  const gs::SplatModel* model;
  const gs::Scene* scene;
};
// Loads the splat of a run by its number. The result is valid until the next call. Throws Error if it cannot be loaded.
using SplatLoader = std::function<PosedSplat(std::size_t run)>;

struct ReportedRun {
  RunSource source;
  std::string missing;                          // reason why its test views are not shown; empty: they are shown
  std::vector<ViewError> views = {};            // test views, worst first
  std::vector<Index> gaussians_of_degree = {};  // number of Gaussians by SH degree, from 0
};

struct ReportedScene {
  std::string scene;
  Index training = 0, held_out = 0, test = 0, points = 0;
  int min_width = 0, max_width = 0, min_height = 0, max_height = 0;  // pixels
  double min_angle = 0, max_angle = 0;                               // horizontal field of view, degrees
  std::string plans;                                                 // CameraPlans
};

// A test view, rendered by the runs.
struct ReportedView {
  std::string scene, name;
  std::vector<std::pair<std::size_t, ViewPictures>> runs;  // runs that have this view
};

struct Report {
  std::vector<ReportedRun> runs;
  std::vector<ReportedScene> scenes;
  std::vector<ReportedView> views;  // views with images: the worst ones, worst first
  Index test_views = 0;             // number of all test views
};

// Calls load twice for each run, in order.
Report GatherReport(std::vector<RunSource> runs, const SplatLoader& load);

// RunSource::scene for a scene folder whose images are downscaled by this factor.
std::string SceneToReport(const std::string& folder, int downscale);

// Gathers the report and writes the page atomically. Throws Error if it cannot be written. Returns a line for each run
// whose test views cannot be shown.
std::vector<std::string> WriteReport(const std::string& file, std::vector<RunSource> runs, const SplatLoader& load);

}  // namespace vesta::app
