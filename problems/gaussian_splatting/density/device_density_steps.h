// The steps of density control on a GPU: what nvcc compiles. All pointers are to memory of the GPU; nothing waits.
#pragma once

#include <cstdint>

#include "kernels/core/span.h"
#include "kernels/gaussian_splatting/types.h"
#include "problems/gaussian_splatting/density/density_formula.h"

namespace vesta::gs::device_density {

// Parameters of `count` Gaussians, and what was observed of them.
struct Observed {
  Index count;
  const float* x;
  const float* pull;
  const int* seen;
};

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

// fate[i] = rule of Gaussian i.
void DecideFates(const FateRule& rule, const Observed& observed, Fate* fate);
// counts[i] = the number of fate[i], 0 for i = count.
void CountFates(Index count, const Fate* fate, const FateNumbers& numbers, Index* counts);
// keys[i] = StrengthKey, indices[i] = i.
void StrengthKeys(const Observed& observed, const Fate* fate, std::uint32_t* keys, std::uint32_t* indices);
// fate[indices[rank]] = kKeep for ranks in [begin, end).
void KeepFrom(Index begin, Index end, const std::uint32_t* indices, Fate* fate);
// For heirs k in [begin[i], begin[i + 1]) of Gaussian i, begin of count + 1: source[k] = i, and whether it keeps
// moments.
void PlaceSources(Index count, const Fate* fate, const Index* begin, std::uint32_t* source, std::uint8_t* kept);
// vesta::gs::Renew for all Gaussians of the new model; fate by Gaussian of the old one.
void RenewAll(Index count, const std::uint32_t* source, const Fate* fate, std::uint64_t seed, int iteration, float* x);
// LoweredLogit of each.
void LowerLogits(Index count, float* logits);

}  // namespace vesta::gs::device_density
