// SPDX-License-Identifier: Apache-2.0
#include "splatting/adam/adam_steps.h"

#include <algorithm>
#include <cmath>

#include "kernels/core/cpu_dispatch.h"
#include "kernels/core/parallel.h"
#include "splatting/adam/adam_kernel.h"

namespace vesta::gs {

AdamRule::AdamRule(const LearningRates& rates, SecondMoment metric, int views)
    : rates_(rates),
      blocks_(metric == SecondMoment::kBlock),
      views_(views),
      beta2_(static_cast<float>(std::pow(double{kAdamBeta2}, views))) {}

float AdamRule::StepFactor(double factor, int steps) const {
  return static_cast<float>(factor * std::sqrt(views_) / (1 - std::pow(double{kAdamBeta1}, steps)));
}

float AdamRule::StepRate(int attribute, double factor, int steps) const {
  return static_cast<float>(RateOf(rates_, attribute) * StepFactor(factor, steps));
}

float AdamRule::RootCorrection2(int steps) const {
  return static_cast<float>(1 / std::sqrt(1 - std::pow(double{beta2_}, steps)));
}

BlockAdamArrays AdamRule::BlockRates(double factor, int steps) const {
  BlockAdamArrays arrays{};
  for (int k = 0; k < kBlockSize; ++k) arrays.rates[k] = static_cast<float>(RateOf(rates_, k));
  arrays.step = StepFactor(factor, steps);
  arrays.beta2 = beta2_;
  arrays.root_correction2 = RootCorrection2(steps);
  return arrays;
}

void AdamSteps<Host>::Run(const AdamStepArrays& arrays, BlockBases<Host>& bases) {
  const BlockAdamArrays& all = arrays.blocks;
  const Index count = arrays.layout.count;
  const AdamKernels kernels = AdamKernelsFor(ActiveIsa());
  ParallelFor((count + kRotationChunk - 1) / kRotationChunk, 1, [&](Index chunk) {
    const Index begin = chunk * kRotationChunk, end = std::min(begin + kRotationChunk, count);
    if (arrays.first_diagonal > 0) {
      BlockAdamArrays piece = all;
      piece.bases = bases.piece(chunk);
      piece.bases_begin = begin;
      kernels.step_blocks(piece, begin, end);
      if (IsChunkRotated(chunk, arrays.seen, arrays.views)) kernels.rotate_bases(piece, begin, end);
    }
    Index first = arrays.layout.Offset(arrays.first_diagonal);  // where the attribute begins
    for (int a = arrays.first_diagonal; a < arrays.attributes; ++a) {
      const Index rows = arrays.layout.Rows(a), offset = first + begin;
      if (rows <= begin) break;  // later attributes have no more rows
      first += rows;
      kernels.step({.size = std::min(end, rows) - begin,
                    .gradient = all.gradient + offset,
                    .parameters = all.parameters + offset,
                    .first = all.first + offset,
                    .second = all.second + offset,
                    .units = a < splat::kLogScale && all.units ? all.units + begin : nullptr,
                    .rate = arrays.rate[a],
                    .beta2 = all.beta2,
                    .root_correction2 = all.root_correction2});
    }
  });
}

VESTA_DECLARE_PER_ISA(const AdamKernels& CompiledAdamKernels();)

const AdamKernels& AdamKernelsFor(Isa isa) { return VESTA_OF_ISA(isa, CompiledAdamKernels)(); }

}  // namespace vesta::gs
