// Adam (Kingma and Ba 2015) on a model, a rate for each class of parameter.
#pragma once

#include <vector>

#include "problems/gaussian_splatting/io/ply.h"
#include "problems/gaussian_splatting/train/options.h"

namespace vesta::gs {

// The rate of attribute a (kernels/gaussian_splatting/layout.h); the position rate times extent.
double RateOf(const LearningRates& rates, int attribute, double extent);

class Adam {
 public:
  Adam(const LearningRates& rates, double extent) : rates_(rates), extent_(extent) {}

  // model -= step, for attributes [0, num_attributes), all rates times `factor`; gradient laid out as the model,
  // zero afterwards. Moments are made on first use. Parallel.
  void Step(SplatModel& model, float* gradient, int num_attributes, double factor);

  // Follow a change of the model: Gaussian i of the new model is source[i] of the old one, with its moments where
  // keep[i], else with none.
  void Rearrange(const std::vector<Index>& source, const std::vector<bool>& keep, int num_attributes);
  // Forget the moments of one attribute.
  void Reset(int attribute);

 private:
  LearningRates rates_;
  double extent_;
  int steps_ = 0;
  Index count_ = 0;
  std::vector<float> first_, second_;  // moments, laid out as the model
};

// The rows `source` of a structure of arrays with `count` rows and `attributes` columns.
std::vector<float> GatherRows(const std::vector<float>& data, Index count, int attributes,
                              const std::vector<Index>& source);

}  // namespace vesta::gs
