// Terms of the memory that training holds which are the same wherever it computes.
#pragma once

#include "problems/gaussian_splatting/lm/options.h"
#include "splatting/adam/options.h"
#include "splatting/memory/memory_scene.h"

namespace vesta::gs {

// One vector of parameters.
double VectorBytes(const MemoryScene& scene);

// A number of 32 bits for each Gaussian.
double PerGaussianBytes(const MemoryScene& scene);

// The bases of Adam's blocks, where it has them.
double BasesBytes(const MemoryScene& scene, const AdamOptions& options);

// Of the Gram matrices of all Gaussians.
double GramBytes(const MemoryScene& scene);

// What passes over views work in and give back.
struct PassingBytes {
  double gram = 0;          // measuring Gram matrices
  double cost = 0;          // the cost of a trial
  double evaluation = 0;    // that of x, and its quality, between iterations
  bool keeps_gram = false;  // ProblemMemory::keeps_gram: the matrices themselves stay
};

// What the engine of LM and the linearizations of its batches hold at the peak, model included. views_bytes: of all
// linearized views together. hold_batches: whether the linearizations of all batches are there at once. passing: what
// is there for a while only.
double EngineBytes(const MemoryScene& scene, const LmStageOptions& lm, bool hold_batches, double views_bytes,
                   const PassingBytes& passing);

}  // namespace vesta::gs
