// A splat, the views that judge it, and what they make of it when it is changed.
#pragma once

#include <vector>

#include "kernels/gaussian_splatting/splat_view.h"
#include "kernels/image/photometric_loss.h"
#include "problems/gaussian_splatting/model/splat_model.h"
#include "problems/gaussian_splatting/parsimony/judging_views.h"

namespace vesta::bench {

// The judges' cost, view by view.
class JudgedModel {
 public:
  // judges must outlive this.
  JudgedModel(const gs::SplatModel& model, const gs::JudgingViews& judges);

  const gs::SplatModel& model() const { return model_; }
  const gs::JudgingViews& judges() const { return judges_; }
  double cost() const;
  // Of the cost, in those views that see Gaussian i, when `change` is done to the model, which is then as before.
  template <class Change>
  double RiseOf(Index i, const Change& change) {
    const gs::SplatModel before = model_;
    change(model_);
    double rise = 0;
    for (std::size_t v = 0; v < costs_.size(); ++v) {
      if (seen_[v][static_cast<std::size_t>(i)] >= 0) rise += CostIn(model_, *judges_.views[v]) - costs_[v];
    }
    model_ = before;
    return rise;
  }
  // Of another model.
  double CostOf(const gs::SplatModel& model);

 private:
  double CostIn(const gs::SplatModel& model, const gs::View& view);

  gs::SplatModel model_;
  const gs::JudgingViews& judges_;
  splat::SplatView<float> splats_;
  splat::ViewWorkspace<float> workspace_;
  PhotometricLoss<float> loss_;
  HostBuffer<float> image_;
  std::vector<double> costs_;
  std::vector<std::vector<std::int32_t>> seen_;
};

}  // namespace vesta::bench
