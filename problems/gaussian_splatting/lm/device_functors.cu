// SPDX-License-Identifier: Apache-2.0
// GPU kernels for the functors of models, scenes and the splatting problem.
#include "kernels/core/for_each.cuh"
#include "problems/gaussian_splatting/lm/gradient_shrinkage.h"
#include "problems/gaussian_splatting/lm/length_metric.h"
#include "problems/gaussian_splatting/model/gather_rows.h"
#include "problems/gaussian_splatting/model/length_units.h"
#include "problems/gaussian_splatting/scene/mask_pixels.h"

namespace vesta {

VESTA_DEVICE_FOR_EACH(gs::LengthMetric<float>, "length metric")
VESTA_DEVICE_FOR_EACH(gs::AddViewGradient<float>, "view gradient")
VESTA_DEVICE_FOR_EACH(gs::ShrunkGradient<float>, "gradient shrinkage")
VESTA_DEVICE_FOR_EACH(gs::RowGathering<std::uint32_t>, "gather rows")
VESTA_DEVICE_FOR_EACH(gs::NumberGathering, "gather counts")
VESTA_DEVICE_FOR_EACH(gs::MeasureUnit, "units of length")
VESTA_DEVICE_FOR_EACH(gs::FillMaskedPixels<float>, "fill masked pixels")
VESTA_DEVICE_FOR_EACH(gs::ChangeBackground<float>, "change the background")
VESTA_DEVICE_FOR_EACH(gs::ClearMaskedPixels<float>, "clear masked pixels")

}  // namespace vesta
