// Adam (Kingma and Ba 2015) on a model, a rate for each class of parameter.
#pragma once

#include <utility>
#include <vector>

#include "problems/gaussian_splatting/io/ply.h"
#include "problems/gaussian_splatting/train/options.h"

namespace vesta::gs {

// The rate of attribute a (kernels/gaussian_splatting/layout.h); of positions in units of length.
double RateOf(const LearningRates& rates, int attribute);

class Adam {
 public:
  explicit Adam(const LearningRates& rates) : rates_(rates) {}

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

  // What a step multiplies: the rate of an attribute over the first moment's bias correction, and the second moment's
  // correction, after so many steps.
  float StepRate(int attribute, double factor, int steps) const;
  static float RootCorrection2(int steps);
  // The moments, laid out as the model; empty before the first step. For a device, which keeps them elsewhere between
  // changes of the model.
  std::vector<float>& first_moments() { return first_; }
  std::vector<float>& second_moments() { return second_; }
  void set_count(Index count) { count_ = count; }

 private:
  LearningRates rates_;
  int steps_ = 0;
  Index count_ = 0;
  std::vector<float> units_;
  std::vector<float> first_, second_;  // moments, laid out as the model
};

// The rows `source` of a structure of arrays with `count` rows and `attributes` columns.
std::vector<float> GatherRows(const std::vector<float>& data, Index count, int attributes,
                              const std::vector<Index>& source);

}  // namespace vesta::gs
