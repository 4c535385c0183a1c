#include "bench/cameras/gains.h"

#include <cmath>
#include <cstddef>
#include <numeric>
#include <utility>

#include "problems/gaussian_splatting/model/median.h"

namespace vesta::bench {

std::vector<double> OfTrainingViews(const gs::Scene& scene, const std::vector<double>& of_views) {
  std::vector<double> of_training;
  for (std::size_t v = 0; v < scene.views.size(); ++v) {
    if (scene.views[v].is_trained()) of_training.push_back(of_views[v]);
  }
  return of_training;
}

std::vector<double> GainsOf(const gs::Scene& scene, const std::vector<gs::ViewUnknowns>& found) {
  std::vector<double> gains = OfTrainingViews(scene, std::vector<double>(scene.views.size(), 1.0));
  for (std::size_t i = 0; i < found.size(); ++i) gains[i] = found[i].color.gain[1];
  return gains;
}

double GainError(const std::vector<double>& truth, const std::vector<double>& found) {
  const auto mean = [](const std::vector<double>& gains) {
    return std::accumulate(gains.begin(), gains.end(), 0.0) / static_cast<double>(gains.size());
  };
  std::vector<double> errors;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    errors.push_back(std::abs(found[i] / mean(found) - truth[i] / mean(truth)));
  }
  return gs::Median(std::move(errors));
}

}  // namespace vesta::bench
