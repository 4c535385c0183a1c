// SPDX-License-Identifier: Apache-2.0
// CUDA instances of the loops of density control.
#include "kernels/core/for_each.cuh"
#include "splatting/density/density_steps.h"

namespace vesta {

VESTA_DEVICE_FOR_EACH(gs::density::Observe, "density statistics")
VESTA_DEVICE_FOR_EACH(gs::density::DecideAction, "densify actions")
VESTA_DEVICE_FOR_EACH(gs::density::CountActions, "counts of densify actions")
VESTA_DEVICE_FOR_EACH(gs::density::MakePullKey, "keys of pulls")
VESTA_DEVICE_FOR_EACH(gs::density::KeepAsItIs, "candidates beyond the budget")
VESTA_DEVICE_FOR_EACH(gs::density::PlaceChildren, "sources of Gaussians")
VESTA_DEVICE_FOR_EACH(gs::density::InitChild, "splits")
VESTA_DEVICE_FOR_EACH(gs::density::LowerLogit, "lowered opacities")

}  // namespace vesta
