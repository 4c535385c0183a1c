// Stage one: Adam on one view an iteration, or a few, with adaptive density.
#include <algorithm>
#include <cmath>
#include <numeric>

#include "kernels/core/random.h"
#include "kernels/gaussian_splatting/layout.h"
#include "kernels/image/photometric_loss.h"
#include "problems/gaussian_splatting/train/density.h"
#include "problems/gaussian_splatting/train/session.h"

namespace vesta::gs {
namespace {

// Training views in random order, each once an epoch.
class ViewOrder {
 public:
  ViewOrder(std::size_t views, std::uint64_t seed) : order_(views), seed_(seed) {}

  std::size_t Next() {
    if (at_ == 0) {
      std::iota(order_.begin(), order_.end(), std::size_t{0});
      CounterRandom random(seed_, epoch_++);
      for (std::size_t i = order_.size(); i > 1; --i) {
        std::swap(order_[i - 1], order_[static_cast<std::size_t>(random.Below(static_cast<Index>(i)))]);
      }
      at_ = order_.size();
    }
    return order_[--at_];
  }

 private:
  std::vector<std::size_t> order_;
  std::uint64_t seed_, epoch_ = 0;
  std::size_t at_ = 0;
};

// Clone, split and prune happen at iteration `it` of `n`.
bool DensifiesAt(const DensityOptions& density, int it, int n) {
  return density.enabled && it % density.interval == 0 && it >= density.begin * n && it <= density.end * n;
}

}  // namespace

void RunAdamStage(TrainingSession& session, SplatModel& model) {
  const TrainOptions& options = session.options();
  const AdamOptions& adam_options = options.adam;
  const int n = adam_options.iterations;
  const double near = NearPlane(session.scene());
  Adam adam(options.rates, session.scene().extent);
  DensityControl density(options.density, session.scene().extent, options.seed, model.count);
  ViewOrder order(session.training_views().size(), options.seed);
  // |e| itself, as in 3DGS: Adam needs no floor.
  PhotometricLoss<float> loss({.l1_floor = 0});
  splat::View<float> view;
  splat::ViewWorkspace<float> workspace;
  Image image;
  HostBuffer<float> image_gradient, gradient;
  double mean_cost = 0;

  const auto active_degree = [&](int it) {
    if (adam_options.sh_band_every <= 0) return model.sh_degree;
    return std::min(model.sh_degree, static_cast<int>((it - 1) / (adam_options.sh_band_every * n)));
  };
  const auto kernel_model = [&](int it) {
    return splat::Model<float>{model.data.data(), model.count, model.sh_degree, active_degree(it)};
  };
  const int record_every = std::max(1, n / adam_options.evaluations);

  for (int it = 1; it <= n && !session.stopped(); ++it) {
    const splat::Model<float> x = kernel_model(it);
    const int attributes = splat::NumAttributes(x.active_sh_degree);
    const bool observes = options.density.enabled && it <= options.density.end * n;
    // Adam leaves it at zero.
    if (gradient.size() != attributes * model.count) gradient.Resize(attributes * model.count);
    double cost = 0, values = 0;
    for (int k = 0; k < adam_options.views_per_iteration; ++k) {
      const View& target = *session.training_views()[order.Next()];
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
      if (observes) density.Observe(view, workspace.splat_sums.data(), static_cast<double>(shape.NumValues()));
    }
    cost /= values;
    // The gradient is that of a sum over pixels and views; Adam's steps do not depend on its scale.
    adam.Step(model, gradient.data(), attributes,
              adam_options.rate_factor * std::pow(adam_options.rate_decay, (it - 1.0) / n));

    if (observes) {
      if (DensifiesAt(options.density, it, n)) density.Densify(model, adam, it);
      const int reset_every = static_cast<int>(options.density.opacity_reset_every * n);
      if (reset_every > 0 && it % reset_every == 0) DensityControl::ResetOpacity(model, adam);
    }
    mean_cost = it == 1 ? cost : 0.95 * mean_cost + 0.05 * cost;
    const bool is_last = it == n || session.ShouldStop();
    if (is_last || it % record_every == 0) session.Record(Stage::kAdam, it, kernel_model(it));
    session.Report({Stage::kAdam, it, n, session.Seconds(), mean_cost, session.latest_psnr(), model.count, ""});
  }
}

}  // namespace vesta::gs
