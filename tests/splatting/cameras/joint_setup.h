// SPDX-License-Identifier: Apache-2.0
// A joint problem with all unknowns perturbed.
#pragma once

#include "splatting/cameras/joint/joint_problem.h"
#include "tests/splatting/cameras/perturbed_view.h"

namespace vesta::gs::test {

template <class S>
struct JointSetup {
  SplatModel model;
  RingProblem<S> ring;
  JointProblemOptions options;
  HostBuffer<S> x;

  JointSetup(const FreeUnknowns& free, int views, Index gaussians, int degree, std::uint64_t seed)
      : model(RandomModel(gaussians, degree, seed)), ring(views, gaussians, degree, seed) {
    options.splats = ring.options;
    options.free = free;
    options.prior = {0.5, 3};
    const JointLayout layout{options.splats.Size(), views, free};
    x.Resize(layout.num_parameters());
    std::copy(ring.x.begin(), ring.x.end(), x.begin());
    for (Index v = 0; v < views; ++v) {
      const double away = 0.01 * static_cast<double>(v + 1);
      layout.SetUnknowns({RandomMotion(1, 0.02, seed + static_cast<std::uint64_t>(v)),
                          {{0.9 + away, 1.1, 1.05 - away}, {0.01, -away, 0.03}}},
                         v, layout.RestOf(x.view()));
    }
  }
  JointProblem<CpuBackend<S>> Make() const { return JointProblem<CpuBackend<S>>(options, ring.views); }
};

}  // namespace vesta::gs::test
