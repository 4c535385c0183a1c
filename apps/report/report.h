// SPDX-License-Identifier: Apache-2.0
// The report of finished trainings: their records, read from their files, and report.html, one page that needs no other
// file.
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

// What the files of a finished training say of it. They may be of another version, or written by hand: what is missing
// or of another kind is not known, and no error.
class RunRecord {
 public:
  // name: what the run is called; metrics: the text of its metrics.json. Throws Error, one line that names the run,
  // where that is no JSON object.
  RunRecord(std::string name, const std::string& metrics, std::int64_t splat_bytes);

  const std::string& name() const { return name_; }
  std::int64_t splat_bytes() const { return splat_bytes_; }  // of point_cloud.ply; 0: there is none
  // At a path of keys, "seconds.total". NaN, and "", where it is not there.
  double Number(const std::string& path) const;
  std::string Text(const std::string& path) const;
  std::vector<std::string> notes() const;
  std::vector<PhaseRow> phases() const;  // of --profile
  // One of the figures of each row of the history of a stage.
  std::vector<double> History(const char* figure) const;
  // Every option, "adam.iterations", as text.
  std::vector<std::pair<std::string, std::string>> Options() const;
  const nlohmann::ordered_json& json() const { return json_; }

 private:
  const nlohmann::ordered_json* At(const std::string& path) const;  // null: not there

  std::string name_;
  nlohmann::ordered_json json_;
  std::int64_t splat_bytes_;
};

// DIR/metrics.json and DIR/point_cloud.ply. Throws Error where the first cannot be read.
RunRecord ReadRun(const std::string& folder);

// Every value beneath an object of objects, "part.key", as text.
std::vector<std::pair<std::string, std::string>> Flattened(const nlohmann::ordered_json& object);

// A run to report, and the scene it trained: a text that only runs of the same photographs at the same size share.
struct RunSource {
  RunRecord record;
  std::string scene;
};

// A splat in the frame of its scene, and that, with the images of its test views at least.
struct PosedSplat {
  const gs::SplatModel* model;
  const gs::Scene* scene;
};
// Of a run by its number; what it gave before need not live any longer. Throws Error where there is none.
using SplatLoader = std::function<PosedSplat(std::size_t run)>;

struct ReportedRun {
  RunSource source;
  std::string missing;                          // why its test views are not shown; empty: they are
  std::vector<ViewError> views = {};            // test views, the worst first
  std::vector<Index> gaussians_of_degree = {};  // of harmonics, from 0 on
};

struct ReportedScene {
  std::string scene;
  Index training = 0, held_out = 0, test = 0, points = 0;
  int min_width = 0, max_width = 0, min_height = 0, max_height = 0;  // pixels
  double min_angle = 0, max_angle = 0;                               // seen from left to right, degrees
  std::string plans;                                                 // CameraPlans
};

// A test view as the runs show it.
struct ReportedView {
  std::string scene, name;
  std::vector<std::pair<std::size_t, ViewPictures>> runs;  // those that have it
};

struct Report {
  std::vector<ReportedRun> runs;
  std::vector<ReportedScene> scenes;
  std::vector<ReportedView> views;  // with pictures: the worst, worst first
  Index test_views = 0;             // all there are
};

// load is called for each run twice, in order.
Report GatherReport(std::vector<RunSource> runs, const SplatLoader& load);

// What RunSource::scene is of a scene's folder, whose images are divided in size by the factor.
std::string SceneToReport(const std::string& folder, int downscale);

// Gathers, and writes the page whole or not at all. Throws Error where it cannot be written. Returns a line for each
// run whose test views could not be shown.
std::vector<std::string> WriteReport(const std::string& file, std::vector<RunSource> runs, const SplatLoader& load);

}  // namespace vesta::app
