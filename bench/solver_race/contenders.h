// SPDX-License-Identifier: Apache-2.0
// The solvers compared on a problem: vesta on a native problem, vesta through the Ceres bridge, and Ceres.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "bench/solver_race/race.h"
#include "problems/bundle_adjustment/bal_file.h"
#include "problems/bundle_adjustment/bundle_problem.h"
#include "solver/lm_options.h"

namespace vesta::bench {

struct RaceOptions {
  int threads = 1;
  double seconds = 60;  // limit of one solve
};

// vesta on a bundle adjustment, as a native problem and through the bridge. `data` is called in the child process.
Contender NativeBundle(const std::string& name, const std::function<bundle::BundleData()>& data,
                       const bundle::BundleProblemOptions& problem, const LmOptions& lm, const RaceOptions& race);
Contender BridgedBundle(const std::string& name, const std::function<bundle::BundleData()>& data, const LmOptions& lm,
                        const RaceOptions& race);
// The same for a pose graph.
Contender NativePoseGraph(const std::string& name, const std::string& path, const LmOptions& lm,
                          const RaceOptions& race);
Contender BridgedPoseGraph(const std::string& name, const std::string& path, const LmOptions& lm,
                           const RaceOptions& race);

std::vector<Contender> BundleContenders(const std::function<bundle::BundleData()>& data, const RaceOptions& options);
// Camera calibration from `views` images of a flat target with `corners` corners.
std::vector<Contender> CalibrationContenders(int views, int corners, const RaceOptions& options);
std::vector<Contender> PoseGraphContenders(const std::string& path, const RaceOptions& options);

}  // namespace vesta::bench
