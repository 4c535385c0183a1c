// SPDX-License-Identifier: Apache-2.0
// What the splatting problem does index by index, compiled for a GPU.
#include "kernels/core/for_each.cuh"
#include "problems/gaussian_splatting/lm/length_metric.h"
#include "problems/gaussian_splatting/lm/view_agreement.h"

namespace vesta {

VESTA_DEVICE_FOR_EACH(gs::LengthMetric<float>, "metric of lengths")
VESTA_DEVICE_FOR_EACH(gs::AddViewGradient<float>, "gradient of a view")
VESTA_DEVICE_FOR_EACH(gs::AgreedDescent<float>, "agreement of views")

}  // namespace vesta
