// By what a Gaussian is judged to be dispensable.
#pragma once

#include <cstdint>
#include <vector>

#include "kernels/core/schema.h"
#include "kernels/gaussian_splatting/project_kernels.h"
#include "problems/gaussian_splatting/parsimony/judging_views.h"

namespace vesta::gs {

enum class Criterion {
  kWorth,        // the rise of the cost without it (worth.h)
  kWeight,       // its shares of the pixels, as Fan et al. 2024 (LightGaussian) and others accumulate them
  kSensitivity,  // how sure the photographs are of its place and size (Hanson et al. 2025, PUP 3D-GS)
  kOpacity,
  kRandom,
};
inline constexpr schema::Choice<Criterion> kCriteria[] = {{Criterion::kWorth, "worth"},
                                                          {Criterion::kWeight, "weight"},
                                                          {Criterion::kSensitivity, "sensitivity"},
                                                          {Criterion::kOpacity, "opacity"},
                                                          {Criterion::kRandom, "random"}};
static_assert(schema::EachOnce(kCriteria));

// By Gaussian: who has less goes first. seed: of kRandom.
std::vector<double> ScoresOf(const splat::Model<float>& model, const JudgingViews& judges, Criterion criterion,
                             std::uint64_t seed);

}  // namespace vesta::gs
