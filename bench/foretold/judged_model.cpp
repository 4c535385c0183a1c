#include "bench/foretold/judged_model.h"

#include <numeric>

#include "problems/gaussian_splatting/model/to_kernel.h"

namespace vesta::bench {

JudgedModel::JudgedModel(const gs::SplatModel& model, const gs::JudgingViews& judges) : model_(model), judges_(judges) {
  costs_.reserve(judges.views.size());
  for (const gs::View* view : judges.views) {
    costs_.push_back(CostIn(model_, *view));
    seen_.emplace_back(splats_.rank_of().begin(), splats_.rank_of().end());
  }
}

double JudgedModel::cost() const { return std::accumulate(costs_.begin(), costs_.end(), 0.0); }

double JudgedModel::CostOf(const gs::SplatModel& model) {
  double cost = 0;
  for (const gs::View* view : judges_.views) cost += CostIn(model, *view);
  return cost;
}

double JudgedModel::CostIn(const gs::SplatModel& model, const gs::View& view) {
  const ImageShape shape{view.camera.width, view.camera.height};
  image_.ResizeForOverwrite(shape.NumValues());
  splats_.Build(gs::ToKernelModel(model), gs::ToPosedCamera(view, judges_.near), judges_.background.data(), workspace_);
  splats_.Render(image_.data());
  return loss_.Evaluate(image_, {view.image.rgb.data(), shape.NumValues()}, shape).objective;
}

}  // namespace vesta::bench
