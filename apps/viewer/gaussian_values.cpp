// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/gaussian_values.h"

#include <utility>

#include "kernels/core/check.h"
#include "problems/gaussian_splatting/model/targets.h"
#include "problems/gaussian_splatting/scene/scene.h"
#include "splatting/cameras/unknowns/moved_view.h"
#include "splatting/pruning/scoring_views.h"

namespace vesta::app {

std::vector<float> RemovalCostColors(const std::vector<double>& rise) {
  std::vector<double> positive;
  for (const double r : rise) {
    if (r > 0) positive.push_back(r);
  }
  const double middle = positive.empty() ? 1 : gs::Median(std::move(positive));
  std::vector<float> scale_positions;
  scale_positions.reserve(rise.size());
  for (const double r : rise) scale_positions.push_back(r > 0 ? static_cast<float>(r / (r + middle)) : 0.0f);
  return scale_positions;
}

std::vector<float> CoverageColors(const std::vector<gs::Coverage>& coverage) {
  std::vector<float> scale_positions;
  scale_positions.reserve(coverage.size());
  for (const gs::Coverage& s : coverage) {
    scale_positions.push_back(s.shown > 0 ? static_cast<float>(s.shown / (s.shown + s.body)) : 0.0f);
  }
  return scale_positions;
}

std::shared_ptr<const MeasuredValues> GaussianValues::Get(GaussianValue value, const ShownModel::Shown& shown) {
  const std::lock_guard lock(mutex_);
  State& state = states_[value];
  const bool is_known = state.latest && state.latest->of.version == shown.version;
  if (!is_known && state.failed_version == shown.version) Fail(kUnavailable, "{}", state.failure);
  if (!is_known && !state.is_measuring && Clock::now() >= state.next_start) {
    background_work_.Run([this, &state, value, shown] { MeasureInto(state, value, shown); });
    state.is_measuring = true;
  }
  return state.latest;
}

void GaussianValues::MeasureInto(State& state, GaussianValue value, const ShownModel::Shown& shown) {
  const Clock::time_point begin = Clock::now();
  std::shared_ptr<const MeasuredValues> measured;
  std::string failure;
  try {
    measured = std::make_shared<const MeasuredValues>(MeasuredValues{shown, Measure(value, shown)});
  } catch (const std::exception& error) {  // missing photograph, or no memory
    failure = error.what();
  }
  const std::lock_guard lock(mutex_);
  state.is_measuring = false;
  const Clock::time_point end = Clock::now();
  state.next_start = end + (end - begin);
  if (measured) {
    state.latest = std::move(measured);
  } else {
    state.failure = std::move(failure), state.failed_version = shown.version;
  }
}

std::vector<float> GaussianValues::Measure(GaussianValue value, const ShownModel::Shown& shown) const {
  const std::vector<gs::View> views = TrainingViews(shown);
  gs::ScoringViews scoring_views{.views = {}, .background = background_, .near = gs::NearPlane(scene_)};
  for (const gs::View& view : views) scoring_views.views.push_back(&view);
  const splat::Model<float> model = gs::ToKernelModel(*shown.model);
  if (value == GaussianValue::kCoverage) return CoverageColors(gs::MeasureCoverage(model, scoring_views));
  return RemovalCostColors(gs::MeasureRemovalCost(model, scoring_views).rise);
}

std::vector<gs::View> GaussianValues::TrainingViews(const ShownModel::Shown& shown) const {
  // Bypasses the store's cache, whose order serves the training.
  const auto store = std::make_shared<gs::PhotographStore>(0);
  std::vector<gs::View> views;
  for (const gs::View& given : scene_.views) {
    if (!given.is_trained()) continue;
    const gs::ViewUnknowns found = shown.cameras ? (*shown.cameras)[views.size()] : gs::ViewUnknowns();
    gs::View& view = views.emplace_back(gs::AsFound(given, found));
    const auto copy = [this, &given, color = found.color] {
      if (ends_) Fail(kUnavailable, "{}: not read, because the viewer is closing", given.image_path);
      gs::Image image = given.stored ? *given.stored->Read() : given.image;
      const HostSpan<float> values{image.rgb.data(), static_cast<Index>(image.rgb.size())};
      if (!color.is_none()) color.Inverse().Apply(values);
      return image;
    };
    const double bytes = gs::kImageBytes * view.camera.pixels();
    view.stored = std::make_shared<gs::StoredPhotograph>(store, gs::PhotographSource{.decode = copy, .bytes = bytes});
  }
  return views;
}

}  // namespace vesta::app
