// SPDX-License-Identifier: Apache-2.0
// The report of finished trainings: its contents, and report.html, one page that needs no other file.
#pragma once

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "apps/report/error_map.h"
#include "apps/report/run_record.h"

namespace vesta::app {

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
