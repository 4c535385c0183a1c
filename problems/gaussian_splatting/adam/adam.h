// Adam (Kingma and Ba 2015) on a model, a rate for each class of parameter, each parameter by itself or the geometric
// ones of a Gaussian together.
#pragma once

#include <utility>
#include <vector>

#include "problems/gaussian_splatting/adam/block_bases.h"
#include "problems/gaussian_splatting/adam/options.h"
#include "problems/gaussian_splatting/model/learning_rates.h"
#include "problems/gaussian_splatting/model/splat_model.h"

namespace vesta::gs {

enum class AdamMetric {
  kDiagonal,  // each parameter has its own second moment
  // Mean, log-scales, quaternion and opacity of a Gaussian are stepped in the eigenbasis of their gradients
  // (block_adam_formula.h), for which 187 numbers more are kept of each Gaussian.
  kBlock,
};

AdamMetric MetricOf(const AdamOptions& options);

// What Adam remembers of the gradients.
struct AdamMoments {
  std::vector<float> first, second;  // laid out as the model; of blocks `second` in the basis
  BlockBases bases;                  // empty unless stepped in blocks
};

class Adam {
 public:
  explicit Adam(const LearningRates& rates, AdamMetric metric = AdamMetric::kDiagonal)
      : rates_(rates), blocks_(metric == AdamMetric::kBlock) {}

  // The unit of length of each Gaussian of the model (length_units.h), to be set anew when those change; without it 1.
  void SetUnits(std::vector<float> units) { units_ = std::move(units); }
  const std::vector<float>& units() const { return units_; }

  // model -= step, for attributes [0, num_attributes), all rates times `factor`; gradient laid out as the model,
  // zero afterwards. Moments are made on first use. Parallel.
  void Step(SplatModel& model, float* gradient, int num_attributes, double factor);

  // Follow a change of the model: Gaussian i of the new model is source[i] of the old one, with its moments where
  // keep[i], else with none.
  void Rearrange(const std::vector<Index>& source, const std::vector<bool>& keep, int num_attributes);
  // Forget the moments of one attribute.
  void Reset(int attribute);

  // Attributes below this one are stepped in blocks, those from it on each parameter by itself.
  int first_diagonal() const;

  // What a step multiplies, after so many steps: the factor over the first moment's bias correction, that times the
  // rate of an attribute, and the second moment's correction.
  static float StepFactor(double factor, int steps);
  float StepRate(int attribute, double factor, int steps) const;
  static float RootCorrection2(int steps);
  // The same for blocks; all pointers null, count 0.
  BlockAdamArrays BlockRates(double factor, int steps) const;

  // Moments, and bases where there are blocks, of a model that has made no step.
  void Start(const SplatModel& model);
  // Those; empty before Start or the first step.
  const AdamMoments& moments() const { return moments_; }
  // For a device, which keeps them elsewhere: takes them away, and gives them back, of so many Gaussians.
  AdamMoments TakeMoments();
  void SetMoments(Index count, AdamMoments moments);

 private:
  LearningRates rates_;
  bool blocks_;
  int steps_ = 0;
  Index count_ = 0;
  std::vector<float> units_;
  AdamMoments moments_;
};

}  // namespace vesta::gs
