#include "problems/gaussian_splatting/parsimony/criterion.h"

#include "kernels/core/random.h"
#include "kernels/gaussian_splatting/layout.h"
#include "problems/gaussian_splatting/parsimony/worth.h"

namespace vesta::gs {
namespace {

std::vector<double> Opacities(const splat::Model<float>& model) {
  const float* logit = model.x + splat::kOpacity * model.count;
  return {logit, logit + model.count};
}

std::vector<double> RandomScores(Index count, std::uint64_t seed) {
  std::vector<double> scores(static_cast<std::size_t>(count));
  for (std::size_t i = 0; i < scores.size(); ++i) scores[i] = CounterRandom(seed, i).Uniform();
  return scores;
}

}  // namespace

std::vector<double> ScoresOf(const splat::Model<float>& model, const JudgingViews& judges, Criterion criterion,
                             std::uint64_t seed) {
  switch (criterion) {
    case Criterion::kWorth:
      return MeasureWorth(model, judges).rise;
    case Criterion::kWeight:
      return MeasureWorth(model, judges).weight;
    case Criterion::kSensitivity:
      return MeasureSensitivity(model, judges);
    case Criterion::kOpacity:
      return Opacities(model);
    case Criterion::kRandom:
      break;
  }
  return RandomScores(model.count, seed);
}

}  // namespace vesta::gs
