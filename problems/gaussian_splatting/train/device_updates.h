// What the Adam stage does to parameters and statistics on a GPU: what nvcc compiles. All pointers are to memory of the
// GPU; nothing waits.
#pragma once

#include "kernels/core/span.h"
#include "kernels/gaussian_splatting/layout.h"
#include "kernels/gaussian_splatting/types.h"

namespace vesta::gs::device_updates {

// parameters -= step, moments and gradient brought up to date and zeroed as AdamUpdate does, for attributes
// [0, attributes) of `count` Gaussians.
struct AdamArrays {
  Index count;
  int attributes;
  float *gradient, *parameters, *first, *second;
  const float* units;                 // [count], factors on the rates of the positions
  float rate[splat::kMaxAttributes];  // of each attribute, Adam::StepRate
  float root_correction2;
};
void StepAdam(const AdamArrays& arrays);

// For Gaussians that are seen: pull += ScreenPull, seen += 1.
struct Observation {
  const std::int32_t* rank_of;
  const splat::Splat<float>* splats;
  const splat::SplatTangent<float>* cotangents;
  float half_width, half_height;
  float* pull;
  int* seen;
};
void Observe(Index count, const Observation& observation);

}  // namespace vesta::gs::device_updates
