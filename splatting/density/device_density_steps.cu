// SPDX-License-Identifier: Apache-2.0
// CUDA instances of the loops of density control.
#include "kernels/core/for_each.cuh"
#include "splatting/density/density_steps.h"

namespace vesta {

VESTA_DEVICE_FOR_EACH(gs::density::Observe, "density statistics")
VESTA_DEVICE_FOR_EACH(gs::density::DecideFate, "fates of Gaussians")
VESTA_DEVICE_FOR_EACH(gs::density::CountFate, "counts of fates")
VESTA_DEVICE_FOR_EACH(gs::density::MakeStrengthKey, "keys of strength")
VESTA_DEVICE_FOR_EACH(gs::density::KeepAsItIs, "candidates without room")
VESTA_DEVICE_FOR_EACH(gs::density::PlaceChildren, "sources of Gaussians")
VESTA_DEVICE_FOR_EACH(gs::density::InitChild, "clones and splits")
VESTA_DEVICE_FOR_EACH(gs::density::LowerLogit, "lowered opacities")

}  // namespace vesta
