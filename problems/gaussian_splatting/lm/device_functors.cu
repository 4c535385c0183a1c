// SPDX-License-Identifier: Apache-2.0
// What models, scenes and the splatting problem do index by index, compiled for a GPU.
#include "kernels/core/for_each.cuh"
#include "problems/gaussian_splatting/lm/gradient_shrinkage.h"
#include "problems/gaussian_splatting/lm/length_metric.h"
#include "problems/gaussian_splatting/model/gather_rows.h"
#include "problems/gaussian_splatting/model/length_units.h"
#include "problems/gaussian_splatting/scene/mask_pixels.h"

namespace vesta {

VESTA_DEVICE_FOR_EACH(gs::LengthMetric<float>, "metric of lengths")
VESTA_DEVICE_FOR_EACH(gs::AddViewGradient<float>, "gradient of a view")
VESTA_DEVICE_FOR_EACH(gs::ShrunkGradient<float>, "agreement of views")
VESTA_DEVICE_FOR_EACH(gs::RowGathering<std::uint32_t>, "gathering of rows")
VESTA_DEVICE_FOR_EACH(gs::CountGathering, "gathering of counts")
VESTA_DEVICE_FOR_EACH(gs::MeasureUnit, "units of length")
VESTA_DEVICE_FOR_EACH(gs::ShowWhereLeftOut<float>, "what a mask leaves out")
VESTA_DEVICE_FOR_EACH(gs::ClearWhereLeftOut<float>, "what a mask leaves out")

}  // namespace vesta
