// SPDX-License-Identifier: Apache-2.0
#include "splatting/cameras/joint/joint_problem.h"

#include "kernels/gaussian_splatting/view/camera_jacobian.h"
#include "problems/gaussian_splatting/lm/splat_blocks.h"
#include "splatting/cameras/joint/joint_linearization.inl"
#include "splatting/cameras/joint/joint_problem.inl"
#include "splatting/cameras/joint/joint_reduced.inl"

namespace vesta::gs {

std::vector<BlockGroup> BlockGroupsOf(const JointProblemOptions& options, const JointLayout& layout) {
  std::vector<BlockGroup> groups = SplatBlockGroups(options.splats);
  const int own = layout.free.num_tangent();
  groups.push_back(
      {.size = own, .count = layout.views, .offset = layout.splats, .component_stride = 1, .block_stride = own});
  return groups;
}

template class JointLinearization<CpuBackend<float>>;
template class JointLinearization<CpuBackend<double>>;
template class JointProblem<CpuBackend<float>>;
template class JointProblem<CpuBackend<double>>;
template class JointReducedSystem<CpuBackend<float>>;
template class JointReducedSystem<CpuBackend<double>>;

}  // namespace vesta::gs
