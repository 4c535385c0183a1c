#include "kernels/core/launch.cuh"
#include "problems/gaussian_splatting/lm/device_view_agreement.h"

namespace vesta::gs::device_view_agreement {

void Add(const AddViewGradient<float>& add, Index count) { device::ForEach(count, add, "gradient of a view"); }

void Descend(const AgreedDescent<float>& descent, Index count) {
  device::ForEach(count, descent, "agreement of views");
}

}  // namespace vesta::gs::device_view_agreement
