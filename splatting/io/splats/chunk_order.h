// SPDX-License-Identifier: Apache-2.0
// Gaussians in chunks that take up little space: numbers that are stored as parts of a chunk's bounds are then finer.
#pragma once

#include <vector>

#include "kernels/core/span.h"
#include "problems/gaussian_splatting/model/splat_model.h"

namespace vesta::gs {

// An order in which the bounds of each `chunk` of Gaussians in turn (the last may be shorter) are narrow: old indices
// in their new order. The means are finite. A curve through space leaves chunks where it leaps; here the Gaussians are
// parted by planes across an axis, again and again, each where the squares of the bounds' sides, summed over Gaussians,
// become least: on a trained scene 0.07 dB of PSNR (docs/results/2026-11-25-compact-formats.md).
std::vector<Index> ChunkOrder(const SplatModel& model, Index chunk);

}  // namespace vesta::gs
