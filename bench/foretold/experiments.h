// What vesta foretells of a change to a splat beside what then happens.
#pragma once

#include <cstdint>
#include <vector>

#include "bench/foretold/judged_model.h"

namespace vesta::bench {

// Rises of the cost, one for each change.
struct Foretold {
  std::vector<double> said, truth;
};

// Single Gaussians drawn at random that go, all others staying as they are (parsimony/worth.h).
Foretold RemoveGaussians(JudgedModel& judged, int count, std::uint64_t seed);

// Single Gaussians drawn at random whose harmonics are lowered, to a degree drawn at random (parsimony/harmonics.h).
// All Gaussians of the splat must have its degree. The splat must have a degree of 1 at least.
Foretold LowerDegrees(JudgedModel& judged, int count, std::uint64_t seed);

// A tenth of the Gaussians at once, and the others make up for it by one step of Levenberg-Marquardt: foretold is what
// the cost would be by the exact loss of images that are linear in that step. Batches of those worth least, next to
// least and so on, and as many drawn at random. extent: of the scene, the unit of lengths.
Foretold RemoveBatches(JudgedModel& judged, double extent, std::uint64_t seed);

}  // namespace vesta::bench
