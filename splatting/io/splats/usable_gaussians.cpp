#include "splatting/io/splats/usable_gaussians.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "kernels/core/check.h"
#include "kernels/core/parallel.h"
#include "problems/gaussian_splatting/model/spatial_order.h"

namespace vesta::gs {
namespace {

// In order.
std::vector<Index> UsableGaussians(const SplatModel& model) {
  std::vector<char> usable(static_cast<std::size_t>(model.count));
  ParallelForChunks(model.count, 4096, [&](Index begin, Index end) {
    for (Index i = begin; i < end; ++i) {
      const float* q = model.attribute(splat::kQuaternion) + i;
      usable[static_cast<std::size_t>(i)] =
          q[0] != 0 || q[model.count] != 0 || q[2 * model.count] != 0 || q[3 * model.count] != 0;
    }
    for (int a = 0; a < model.num_attributes(); ++a) {
      const float* values = model.attribute(a);
      for (Index i = begin; i < std::min(end, model.Rows(a)); ++i) {
        if (!std::isfinite(values[i])) usable[static_cast<std::size_t>(i)] = false;
      }
    }
  });
  std::vector<Index> indices;
  for (Index i = 0; i < model.count; ++i) {
    if (usable[static_cast<std::size_t>(i)]) indices.push_back(i);
  }
  return indices;
}

}  // namespace

void TakeUsableGaussians(const std::string& path, const ReadSplatOptions& options, SplatModel* model) {
  const std::vector<Index> usable = UsableGaussians(*model);
  const Index bad = model->count - static_cast<Index>(usable.size());
  if (bad == 0) return;
  if (!options.drop_unusable || usable.empty()) {
    Fail("{}: {} of {} Gaussians have values that are not finite or a zero quaternion; remove them, or train again",
         path, bad, model->count);
  }
  *model = InOrder(std::move(*model), usable);
}

void CheckDrawable(const std::string& path, const SplatModel& model) {
  VESTA_CHECK(model.sh_degree >= 0 && model.sh_degree <= 3, "degree {}", model.sh_degree);
  VESTA_CHECK(static_cast<Index>(model.data.size()) == model.Size(), "{} values for {} Gaussians of degree {}",
              model.data.size(), model.count, model.sh_degree);
  const Index bad = model.count - static_cast<Index>(UsableGaussians(model).size());
  if (bad > 0) {
    Fail(
        "{}: {} of {} Gaussians have values that are not finite or a zero quaternion, which this format has no numbers "
        "for; remove them, or train again",
        path, bad, model.count);
  }
}

}  // namespace vesta::gs
