// Stage one: Adam on one view an iteration, or a few, with adaptive density.
#include <algorithm>

#include "kernels/gaussian_splatting/layout.h"
#include "kernels/image/photometric_loss.h"
#include "problems/gaussian_splatting/adam/parameter_mean.h"
#include "problems/gaussian_splatting/adam/schedule.h"
#include "problems/gaussian_splatting/density/density.h"
#include "problems/gaussian_splatting/density/schedule.h"
#include "problems/gaussian_splatting/train/coarse_views.h"
#include "problems/gaussian_splatting/train/session.h"
#include "problems/gaussian_splatting/train/stage_switch.h"

namespace vesta::gs {

void RunAdamStage(TrainingSession& session, SplatModel& model) {
  const TrainOptions& options = session.options();
  const AdamOptions& adam_options = options.adam;
  const int n = adam_options.iterations;
  const double near = NearPlane(session.scene());
  Adam adam(options.rates, MetricOf(adam_options));
  adam.SetUnits(TrainingUnits(session, model));
  DensityControl density(options.density, session.scene().extent, options.seed, model.count);
  std::vector<View> coarse_views;
  if (IsCoarseAt(adam_options, 1)) coarse_views = CoarseViews(session.training_views());
  StageSwitch stage_switch(options, static_cast<Index>(session.training_views().size()));
  ViewOrder order(session.training_views().size(), options.seed);
  // |e| itself, as in 3DGS: Adam needs no floor.
  PhotometricLoss<float> loss({.l1_floor = 0});
  splat::View<float> view;
  splat::ViewWorkspace<float> workspace;
  Image image;
  HostBuffer<float> image_gradient, gradient;
  ParameterMean<CpuBackend<float>> average;
  double mean_cost = 0;

  const auto parameters = [&] {
    return HostSpan<const float>(model.data.data(), static_cast<Index>(model.data.size()));
  };
  const auto kernel_model = [&](HostSpan<const float> x, int it) {
    return splat::Model<float>{x.data(), model.count, model.sh_degree,
                               ActiveShDegree(adam_options, model.sh_degree, it)};
  };
  const int record_every = std::max(1, n / adam_options.evaluations);

  for (int it = 1; it <= stage_switch.end() && !session.stopped(); ++it) {
    const splat::Model<float> x = kernel_model(parameters(), it);
    const int attributes = splat::NumAttributes(x.active_sh_degree);
    if (!IsCoarseAt(adam_options, it)) coarse_views = std::vector<View>();
    const bool observes = options.density.enabled && it <= options.density.end * n;
    // Adam leaves it at zero.
    if (gradient.size() != attributes * model.count) gradient.Resize(attributes * model.count);
    double cost = 0, values = 0;
    for (int k = 0; k < adam_options.views_per_iteration; ++k) {
      const std::size_t next = order.Next();
      const View& full = *session.training_views()[next];
      const View& target = coarse_views.empty() ? full : coarse_views[next];
      const ImageShape shape{target.camera.width, target.camera.height};
      if (image.width != shape.width || image.height != shape.height) {
        image = Image(shape.width, shape.height);
        image_gradient.Resize(shape.NumValues());
      }
      const HostSpan<const float> rendered(image.rgb.data(), shape.NumValues());
      const HostSpan<const float> truth(target.image.rgb.data(), shape.NumValues());

      view.Build(x, ToPinhole(target, near), options.background.data(), workspace);
      view.Render(image.rgb.data());
      cost += loss.Gradient(rendered, truth, shape, image_gradient).objective;
      values += static_cast<double>(shape.NumValues());
      view.AddJT(x, image.rgb.data(), image_gradient.data(), gradient.data(), workspace);
      if (observes) {
        const double share = PullShare(shape.width, full.camera.width);
        density.Observe(view, workspace.splat_sums.data(), share * static_cast<double>(shape.NumValues()));
      }
    }
    cost /= values;
    // The gradient is that of a sum over pixels and views; Adam's steps do not depend on its scale.
    adam.Step(model, gradient.data(), attributes, RateFactor(adam_options, it, stage_switch.end()));
    stage_switch.Observe(it, cost);

    if (AveragesAt(adam_options, it, stage_switch.end())) average.Add(parameters());
    mean_cost = it == 1 ? cost : 0.95 * mean_cost + 0.05 * cost;
    const bool is_last = it == stage_switch.end() || session.ShouldStop();
    const HostSpan<const float> result = average.empty() ? parameters() : HostSpan<const float>(average.value());
    if (is_last || it % record_every == 0) session.Record(Stage::kAdam, it, kernel_model(result, it));
    if (is_last && !average.empty()) std::copy(result.begin(), result.end(), model.data.begin());
    // After the row of the history, and not at the end: what has just been cloned or split is worse for some
    // iterations.
    if (observes && !is_last) {
      const bool densifies = DensifiesAt(options.density, it, n), resets = ResetsOpacityAt(options.density, it, n);
      if (densifies || resets) average.StartAnew();  // first: its memory is wanted
      if (densifies) {
        density.Densify(model, adam, it);
        adam.SetUnits(TrainingUnits(session, model));
      }
      if (resets) DensityControl::ResetOpacity(model, adam);
    }
    session.Report(
        {Stage::kAdam, it, stage_switch.end(), session.Seconds(), mean_cost, session.latest_psnr(), model.count, ""});
  }
}

}  // namespace vesta::gs
