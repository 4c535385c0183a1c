// SPDX-License-Identifier: Apache-2.0
// The solvers to compare (contenders): vesta with its own problem class (native), vesta through the bridge from a
// ceres::Problem (bridged), and Ceres.
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
  double seconds = 60;  // of one solve
};

// vesta on a bundle adjustment. `data` returns the problem, in the child process.
Contender NativeBundle(const std::string& name, const std::function<bundle::BundleData()>& data,
                       const bundle::BundleProblemOptions& problem, const LmOptions& lm, const RaceOptions& race);
Contender BridgedBundle(const std::string& name, const std::function<bundle::BundleData()>& data, const LmOptions& lm,
                        const RaceOptions& race);
// vesta on the pose graph in the file `path`.
Contender NativePoseGraph(const std::string& name, const std::string& path, const LmOptions& lm,
                          const RaceOptions& race);
Contender BridgedPoseGraph(const std::string& name, const std::string& path, const LmOptions& lm,
                           const RaceOptions& race);

// All contenders for a bundle adjustment.
std::vector<Contender> BundleContenders(const std::function<bundle::BundleData()>& data, const RaceOptions& options);
// All contenders for a synthetic camera calibration from `views` images of a flat target with `corners` corners.
std::vector<Contender> CalibrationContenders(int views, int corners, const RaceOptions& options);
// All contenders for the pose graph in the file `path`.
std::vector<Contender> PoseGraphContenders(const std::string& path, const RaceOptions& options);

}  // namespace vesta::bench
