// SPDX-License-Identifier: Apache-2.0
// The report of one or several finished trainings (runs): reads their metrics.json, renders their test views and writes
// report.html.
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

// The metrics.json of a finished training (docs/guide/metrics.md). It may come from another version of vesta or be
// edited by hand, so a key that is missing or has another type is not an error: the value is then unknown.
class RunRecord {
 public:
  // name: name of the run for the report. metrics: the text of its metrics.json; throws Error (one line with the name)
  // if it is not a JSON object. splat_bytes: size of point_cloud.ply; 0: missing.
  RunRecord(std::string name, const std::string& metrics, std::int64_t splat_bytes);

  const std::string& name() const { return name_; }
  std::int64_t splat_bytes() const { return splat_bytes_; }  // size of point_cloud.ply; 0: missing
  // The number or text at a path of keys such as "seconds.total"; NaN or "" if it is unknown.
  double Number(const std::string& path) const;
  std::string Text(const std::string& path) const;
  std::vector<std::string> notes() const;
  std::vector<PhaseRow> phases() const;  // with --profile
  // The value of a key, such as "test_psnr", in each row of the history; NaN if unknown.
  std::vector<double> History(const char* figure) const;
  // The keys, such as "adam.iterations", and values of all options of the training, as text.
  std::vector<std::pair<std::string, std::string>> Options() const;
  const nlohmann::ordered_json& json() const { return json_; }

 private:
  const nlohmann::ordered_json* At(const std::string& path) const;  // null: unknown

  std::string name_;
  nlohmann::ordered_json json_;
  std::int64_t splat_bytes_;
};

// Reads FOLDER/metrics.json and the size of FOLDER/point_cloud.ply. Throws Error if metrics.json cannot be read.
RunRecord ReadRun(const std::string& folder);

// Returns the values of a JSON object of objects as texts, with the names "OUTER.INNER" of their keys.
std::vector<std::pair<std::string, std::string>> Flattened(const nlohmann::ordered_json& object);

// A run to report. scene: identifies the scene; it is equal for two runs only if they use the same photographs at the
// same size (SceneToReport).
struct RunSource {
  RunRecord record;
  std::string scene;
};

// A splat in the frame of its scene, and the scene with the photographs of at least its test views.
struct PosedSplat {
  const gs::SplatModel* model;
  const gs::Scene* scene;
};
// Loads the splat and scene of a run, given its index. The result is valid until the next call. Throws Error if that
// fails.
using SplatLoader = std::function<PosedSplat(std::size_t run)>;

struct ReportedRun {
  RunSource source;
  std::string missing;                          // why the test views are not shown; empty: they are shown
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

// A test view, rendered with the splats of several runs.
struct ReportedView {
  std::string scene, name;
  std::vector<std::pair<std::size_t, ViewPictures>> runs;  // index of the run, and its images
};

struct Report {
  std::vector<ReportedRun> runs;
  std::vector<ReportedScene> scenes;
  std::vector<ReportedView> views;  // the views that the page shows as images: the worst ones, worst first
  Index test_views = 0;             // number of all test views
};

// Measures and renders the test views of all runs. Calls `load` twice for each run, in order.
Report GatherReport(std::vector<RunSource> runs, const SplatLoader& load);

// Returns RunSource::scene for a scene folder and a downscaling factor.
std::string SceneToReport(const std::string& folder, int downscale);

// Makes the report and writes its page to `file`, atomically. Returns one line for the user for each run whose test
// views cannot be shown. Throws Error if the file cannot be written.
std::vector<std::string> WriteReport(const std::string& file, std::vector<RunSource> runs, const SplatLoader& load);

}  // namespace vesta::app
