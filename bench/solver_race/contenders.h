// The contenders on a problem: vesta natively, vesta through the bridge, and Ceres's solvers.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "bench/solver_race/race.h"
#include "problems/bundle_adjustment/bundle_data.h"

namespace vesta::bench {

struct RaceOptions {
  int threads = 1;
  double seconds = 60;  // limit of one solve
};

// data is called in the child process.
std::vector<Contender> BundleContenders(const std::function<bundle::BundleData()>& data, const RaceOptions& options);
// views of a flat target with so many corners each.
std::vector<Contender> CalibrationContenders(int views, int corners, const RaceOptions& options);
std::vector<Contender> PoseGraphContenders(const std::string& path, const RaceOptions& options);

}  // namespace vesta::bench
