// What the Adam stage does to parameters and statistics on a GPU: what nvcc compiles. All pointers are to memory of the
// GPU; nothing waits.
#pragma once

#include <cstdint>

#include "kernels/core/span.h"
#include "kernels/gaussian_splatting/layout.h"
#include "kernels/gaussian_splatting/types.h"
#include "problems/gaussian_splatting/adam/block_adam_formula.h"

namespace vesta::gs::device_updates {

// parameters -= step, moments brought up to date and the gradient zeroed as AdamKernels::step does, for attributes
// [first_attribute, attributes) of `count` Gaussians.
struct AdamArrays {
  Index count;
  int first_attribute, attributes;
  float *gradient, *parameters, *first, *second;
  const float* units;                 // [count], factors on the rates of the positions
  float rate[splat::kMaxAttributes];  // of each attribute, Adam::StepRate
  float root_correction2;
};
void StepAdam(const AdamArrays& arrays);

// BlockAdamStep for all Gaussians, and TurnBasis for those whose turn it is after so many steps.
void StepBlocks(const BlockAdamArrays& arrays);
void TurnBases(const BlockAdamArrays& arrays, int steps);

// to = the rows `source` of `from`: structures of arrays with `attributes` columns of so many rows; zero where a row is
// not kept. kept null: all are.
struct RowGathering {
  Index attributes, from_rows, to_rows;
  const std::uint32_t* source;
  const std::uint8_t* kept;
  const float* from;
  float* to;
};
void GatherRows(const RowGathering& gathering);
// The same for bases, of which Gaussians that are not kept have the directions, not C.
struct BaseGathering {
  Index to_rows;
  const std::uint32_t* source;
  const std::uint8_t* kept;
  const float* from;
  float* to;  // BlockArraySize(to_rows)
};
void GatherBases(const BaseGathering& gathering);

// LengthUnit of `count` Gaussians, by so many views in the memory of the GPU.
void MeasureUnits(Index count, const float* parameters, const splat::PinholeView* views, Index num_views,
                  double otherwise, float* units);

}  // namespace vesta::gs::device_updates
