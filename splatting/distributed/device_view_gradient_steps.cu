// SPDX-License-Identifier: Apache-2.0
// CUDA instances of the loops over terms of a gradient.
#include "kernels/core/for_each.cuh"
#include "splatting/distributed/view_gradient_steps.h"

namespace vesta {

VESTA_DEVICE_FOR_EACH(gs::term::CountVisible, "visible blocks")
VESTA_DEVICE_FOR_EACH(gs::term::PlaceBlocks, "places of blocks")
VESTA_DEVICE_FOR_EACH(gs::term::CountEither, "blocks of either term")
VESTA_DEVICE_FOR_EACH(gs::term::ListBlocks, "list of blocks")
VESTA_DEVICE_FOR_EACH(gs::term::ExtractRow, "gradient of a view")
VESTA_DEVICE_FOR_EACH(gs::term::ObserveBlock, "density statistics of a view")
VESTA_DEVICE_FOR_EACH(gs::term::AddRow, "sum of terms")
VESTA_DEVICE_FOR_EACH(gs::term::CopyRow, "sum of gradients")
VESTA_DEVICE_FOR_EACH(gs::term::AddPull, "sum of density statistics")

}  // namespace vesta
