#include "splatting/memory/engine_bytes.h"

#include <algorithm>
#include <cmath>

#include "kernels/core/packed.h"
#include "kernels/gaussian_splatting/formulas/layout.h"
#include "kernels/math/spherical_harmonics.h"
#include "problems/gaussian_splatting/lm/engine_options.h"
#include "problems/gaussian_splatting/lm/view_batches.h"
#include "solver/memory.h"
#include "splatting/adam/adam_rule.h"
#include "splatting/adam/block_adam_formula.h"

namespace vesta::gs {

double VectorBytes(const MemoryScene& scene) { return sizeof(float) * static_cast<double>(scene.layout.Size()); }

double PerGaussianBytes(const MemoryScene& scene) { return sizeof(float) * static_cast<double>(scene.layout.count); }

double BasesBytes(const MemoryScene& scene, const AdamOptions& options) {
  return options.metric == AdamMetric::kBlock ? sizeof(float) * static_cast<double>(BlockArraySize(scene.layout.count))
                                              : 0;
}

// Packed blocks of the geometry, and the diagonal of the harmonics.
double GramBytes(const MemoryScene& scene) {
  return (PackedSize(splat::kGeometry) - splat::kSh) * PerGaussianBytes(scene) + VectorBytes(scene);
}

double EngineBytes(const MemoryScene& scene, const LmStageOptions& lm, bool hold_batches, double views_bytes,
                   const PassingBytes& passing) {
  vesta::LmOptions engine = LmEngineOptions(lm);
  engine.hold_batches = hold_batches;
  const auto views = static_cast<double>(scene.views.size());
  const Index batches = ViewBatches::CutCount(lm.batches, lm.batch_size, static_cast<Index>(scene.views.size()));
  const int linearizations = HeldLinearizations(engine, static_cast<int>(batches));
  // Views in each batch, up to one more in some than in others.
  const double size =
      std::ceil(lm.batch_size > 0 ? std::min<double>(lm.batch_size, views) : views / static_cast<double>(batches));
  const double held = std::min(linearizations * size, views);
  // The Gram matrices of a linearization, which become the blocks of a preconditioner.
  const double blocks = GramBytes(scene);
  const double vector = VectorBytes(scene);
  return LmPeakBytes(engine, {.batches = static_cast<int>(batches),
                              .vector = vector,
                              .linearization = views_bytes * (views > 0 ? held / views : 0) / linearizations +
                                               2 * kImageBytes * scene.Largest().pixels,
                              .gram = blocks,
                              .gram_work = passing.gram,
                              .keeps_gram = passing.keeps_gram,
                              .blocks = blocks,
                              .cost_work = passing.cost,
                              .between = passing.evaluation,
                              .has_own_descent = lm.view_agreement > 0,
                              .has_own_metric = lm.damping == LmDamping::kRates});
}

}  // namespace vesta::gs
