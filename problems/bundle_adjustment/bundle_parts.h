// SPDX-License-Identifier: Apache-2.0
// Divides a bundle adjustment into parts for several processes (docs/scaling.md). Each part has a range of points, the
// observations of these points, and all cameras. Each part eliminates its own points.
#pragma once

#include <vector>

#include "problems/bundle_adjustment/bundle_problem.h"
#include "solver/distributed/problem_parts.h"

namespace vesta::bundle {

class BundleParts final : public ProblemParts<CpuBackend<double>> {
 public:
  // Parts have about the same number of observations, and at least one point. data must outlive this object. Throws
  // Error for num_parts < 1.
  BundleParts(const BundleData& data, int num_parts, BundleProblemOptions options = {});

  int num_parts() const override { return static_cast<int>(first_point_.size()) - 1; }
  ProblemPart<CpuBackend<double>> Make(int part) override;
  Index num_parameters() const override;
  std::vector<BlockGroup> block_groups() const override;
  bool eliminates() const override { return true; }

 private:
  const BundleData& data_;
  BundleProblemOptions options_;
  std::vector<Index> first_point_;  // the first point of each part, then the number of points
  // Observations sorted by point, as indices into data.observations: point i has
  // by_point_[first_[i]]..by_point_[first_[i + 1] - 1].
  std::vector<Index> by_point_, first_;
};

}  // namespace vesta::bundle
