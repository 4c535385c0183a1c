// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <utility>

#include "kernels/core/divisor.h"
#include "kernels/core/launch.cuh"
#include "splatting/adam/device_adam_steps.h"

namespace vesta::gs {
namespace {

// Steps the attributes from `first` on that have `rows` Gaussians each. Memory bound: 16 bytes per parameter with a
// gradient are read and written; 4 are read for the others.
struct StepOne {
  AdamStepArrays a;
  int first;
  Index rows, offset{a.layout.Offset(first)};
  Divisor by_rows{rows};
  VESTA_HD void operator()(Index parameter) const {
    const BlockAdamArrays& all = a.blocks;
    const auto [from_first, gaussian] = by_rows.Divide(parameter);
    const Index i = offset + parameter;
    if (all.gradient[i] == 0) return;
    const Index attribute = first + from_first;
    const float unit = attribute < splat::kLogScale && all.units ? all.units[gaussian] : 1.0f;
    const float step = AdamStep(all.gradient[i], unit * a.rate[attribute], all.beta2, all.root_correction2,
                                all.first[i], all.second[i]);
    all.gradient[i] = 0;
    all.parameters[i] -= step;
  }
};

struct StepBlock {
  BlockAdamArrays a;
  VESTA_HD void operator()(Index gaussian) const { BlockAdamStep<float>(a, gaussian); }
};

// Three matrices exceed the registers and are in local memory; only one Gaussian in 25 needs them.
struct RotateOne {
  BlockAdamArrays a;
  Index first_chunk, end;
  VESTA_HD void operator()(Index k) const {
    const Index chunk = first_chunk + k / kRotationChunk * kRotationInterval;
    const Index i = chunk * kRotationChunk + k % kRotationChunk;
    if (i < end) RotateBasis<float>(a, i);
  }
};

struct GatherBasisNumber {
  Index to_rows;
  const std::uint32_t* source;
  const std::uint8_t* kept;
  const float* from;
  float* to;
  // entry: an index as in BlockEntry.
  VESTA_HD void operator()(Index entry) const {
    const Index block = entry / (kBlockNumbers * kBlockLanes), in_block = entry - block * kBlockNumbers * kBlockLanes;
    const int number = static_cast<int>(in_block / kBlockLanes);
    const Index i = block * kBlockLanes + in_block % kBlockLanes;
    const bool is_kept = i < to_rows && (kept[i] != 0 || number < kBasisSize);
    to[entry] = is_kept ? from[BlockEntry(number, source[i])] : 0.0f;
  }
};

}  // namespace

void BlockBases<Device>::Rearrange(Span<const std::uint32_t, Device> source, Span<const std::uint8_t, Device> kept) {
  DeviceBuffer<float> gathered;
  gathered.ResizeForOverwrite(BlockArraySize(source.size()));
  device::ForEach(gathered.size(),
                  GatherBasisNumber{source.size(), source.data(), kept.data(), numbers_.data(), gathered.data()},
                  "gathering of Adam's bases");
  numbers_ = std::move(gathered);
}

BlockBases<Host> BlockBases<Device>::OnHost(Index count) const {
  HostBuffer<float> flat;
  flat.ResizeForOverwrite(numbers_.size());
  numbers_.CopyTo(flat);
  return {numbers_.empty() ? 0 : count, flat};
}

void AdamSteps<Device>::Run(const AdamStepArrays& arrays, BlockBases<Device>& bases) {
  const BlockAdamArrays& all = arrays.blocks;
  const Index count = arrays.layout.count;
  if (arrays.first_diagonal > 0) {
    BlockAdamArrays blocks = all;
    blocks.bases = bases.data();
    device::ForEach(count, StepBlock{blocks}, "step of Adam's blocks");
    const Index chunks = (count + kRotationChunk - 1) / kRotationChunk;
    const auto rotated = [](Index chunks_to_go) { return (chunks_to_go + kRotationInterval - 1) / kRotationInterval; };
    for (Index k = 0; k < std::min<Index>(arrays.views, kRotationInterval); ++k) {
      const Index first = FirstRotatedChunk(arrays.seen - k);
      device::ForEach(rotated(std::max<Index>(chunks - first, 0)) * kRotationChunk, RotateOne{blocks, first, count},
                      "rotation of Adam's bases");
    }
  }
  for (int first = arrays.first_diagonal, end = 0; first < arrays.attributes; first = end) {
    const Index rows = arrays.layout.Rows(first);
    // Up to the last attribute with the same number of Gaussians.
    for (end = first; end < arrays.attributes && arrays.layout.Rows(end) == rows;) ++end;
    if (rows > 0) device::ForEach((end - first) * rows, StepOne{arrays, first, rows}, "step of Adam");
  }
}

}  // namespace vesta::gs
