// SPDX-License-Identifier: Apache-2.0
// A bundle adjustment cut into runs of points, to be spread over processes: each part has all cameras, its points and
// their observations. Cameras are what parts share; points are eliminated part by part.
#pragma once

#include <vector>

#include "problems/bundle_adjustment/bundle_problem.h"
#include "solver/distributed/problem_parts.h"

namespace vesta::bundle {

class BundleParts final : public ProblemParts<CpuBackend<double>> {
 public:
  // Parts of about as many observations each; no more than there are points. data must outlive this object. Throws
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
  std::vector<Index> first_point_;  // of each part, and the end
  // Observations by point, as numbers of data's: those of point i are by_point_[first_[i]] and what follows.
  std::vector<Index> by_point_, first_;
};

}  // namespace vesta::bundle
