// SPDX-License-Identifier: Apache-2.0
#include "splatting/cameras/joint/joint_problem.h"

#include "problems/gaussian_splatting/lm/splat_blocks.h"

namespace vesta::gs {

std::vector<BlockGroup> BlockGroupsOf(const JointProblemOptions& options, const JointLayout& layout) {
  std::vector<BlockGroup> groups = SplatBlockGroups(options.splats);
  const int own = layout.free.num_tangent();
  groups.push_back(
      {.size = own, .count = layout.views, .offset = layout.splats, .component_stride = 1, .block_stride = own});
  return groups;
}

}  // namespace vesta::gs
