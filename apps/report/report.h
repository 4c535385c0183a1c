// SPDX-License-Identifier: Apache-2.0
// The report of finished trainings (runs): reads their metrics.json, renders their test views and writes report.html.
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
// edited by hand, so a missing key or wrong type is not an error: the value is then unknown.
class RunRecord {
 public:
  // metrics: text of metrics.json; throws Error (one line with the name) if it is not a JSON object. splat_bytes: size
  // of point_cloud.ply; 0: missing.
  RunRecord(std::string name, const std::string& metrics, std::int64_t splat_bytes);

  const std::string& name() const { return name_; }
  std::int64_t splat_bytes() const { return splat_bytes_; }  // 0: no point_cloud.ply
  // The value at a path of keys such as "seconds.total"; NaN or "" if unknown.
  double Number(const std::string& path) const;
  std::string Text(const std::string& path) const;
  std::vector<std::string> notes() const;
  std::vector<PhaseRow> phases() const;  // with --profile
  // The value of a key, such as "test_psnr", in each row of the history; NaN if unknown.
  std::vector<double> History(const char* figure) const;
  // All options as text: key, such as "adam.iterations", and value.
  std::vector<std::pair<std::string, std::string>> Options() const;
  const nlohmann::ordered_json& json() const { return json_; }

 private:
  const nlohmann::ordered_json* At(const std::string& path) const;  // null: unknown

  std::string name_;
  nlohmann::ordered_json json_;
  std::int64_t splat_bytes_;
};

// Throws Error if FOLDER/metrics.json cannot be read.
RunRecord ReadRun(const std::string& folder);

// The values of a JSON object of objects as texts, with names "OUTER.INNER".
std::vector<std::pair<std::string, std::string>> Flattened(const nlohmann::ordered_json& object);

// scene: from SceneToReport; equal for two runs only if they use the same photographs at the same size.
struct RunSource {
  RunRecord record;
  std::string scene;
};

// The trained model of a run, and the scene of the run. The model has the coordinates of the scene
// (model/scene_frame.h). At least the test views of the scene have photographs.
struct PosedSplat {
  const gs::SplatModel* model;
  const gs::Scene* scene;
};
// Loads splat and scene of the run with this index, valid until the next call. Throws Error if loading fails.
using SplatLoader = std::function<PosedSplat(std::size_t run)>;

struct ReportedRun {
  RunSource source;
  std::string missing;                          // why the test views are not shown; empty: they are
  std::vector<ViewError> views = {};            // test views, worst first
  std::vector<Index> gaussians_of_degree = {};  // by SH degree, from 0
};

struct ReportedScene {
  std::string scene;
  Index training = 0, held_out = 0, test = 0, points = 0;
  int min_width = 0, max_width = 0, min_height = 0, max_height = 0;  // pixels
  double min_angle = 0, max_angle = 0;                               // horizontal field of view, degrees
  std::string plans;                                                 // CameraPlans
};

// A test view, rendered by several runs.
struct ReportedView {
  std::string scene, name;
  std::vector<std::pair<std::size_t, ViewPictures>> runs;  // index of the run, its images
};

struct Report {
  std::vector<ReportedRun> runs;
  std::vector<ReportedScene> scenes;
  // The test views that the page shows as images: the ones with the lowest PSNR in any run, lowest first.
  std::vector<ReportedView> views;
  // Number of test views that any run has measured. A view that several runs share counts once.
  Index test_views = 0;
};

// Measures the test views of all runs, and renders the worst ones. First calls `load` for each run in order, to measure
// its test views. Then calls it again for each run with measured views, to render the chosen ones.
Report GatherReport(std::vector<RunSource> runs, const SplatLoader& load);

// RunSource::scene for a folder and a downscaling factor.
std::string SceneToReport(const std::string& folder, int downscale);

// Writes the page to `file`, atomically. Returns one line for each run whose test views cannot be shown. Throws Error
// if the file cannot be written.
std::vector<std::string> WriteReport(const std::string& file, std::vector<RunSource> runs, const SplatLoader& load);

}  // namespace vesta::app
