// Stage one on a GPU. Parameters, gradient and moments stay in its memory between changes of the model's size, which
// happen on the host.
#include "problems/gaussian_splatting/train/device_adam_stage.h"

#include <algorithm>

#include "kernels/gaussian_splatting/device_view.h"
#include "kernels/image/device_photometric_loss.h"
#include "problems/gaussian_splatting/lm/device_splat_problem.h"
#include "problems/gaussian_splatting/train/adam_schedule.h"
#include "problems/gaussian_splatting/train/density.h"
#include "problems/gaussian_splatting/train/device_updates.h"
#include "problems/gaussian_splatting/train/lm_steps.h"

namespace vesta::gs {
namespace {

template <class T>
HostSpan<const T> ViewOf(const std::vector<T>& v) {
  return {v.data(), static_cast<Index>(v.size())};
}

template <class T>
std::vector<T> Download(const DeviceBuffer<T>& buffer) {
  std::vector<T> values(static_cast<std::size_t>(buffer.size()));
  buffer.CopyTo({values.data(), buffer.size()});
  return values;
}

// The model and all that goes with each parameter.
class DeviceModel {
 public:
  DeviceModel(SplatModel& model, Adam& adam, DensityControl& density) : model_(model), adam_(adam), density_(density) {
    Upload();
  }

  splat::Model<float> kernel_model(int active_sh_degree) const {
    return {x_.data(), model_.count, model_.sh_degree, active_sh_degree};
  }
  float* gradient() { return gradient_.data(); }

  void Step(int attributes, double factor) {
    ++steps_;
    device_updates::AdamArrays arrays{.count = model_.count,
                                      .attributes = attributes,
                                      .gradient = gradient_.data(),
                                      .parameters = x_.data(),
                                      .first = first_.data(),
                                      .second = second_.data(),
                                      .units = units_.data(),
                                      .rate = {},
                                      .root_correction2 = Adam::RootCorrection2(steps_)};
    for (int a = 0; a < attributes; ++a) arrays.rate[a] = adam_.StepRate(a, factor, steps_);
    device_updates::StepAdam(arrays);
  }
  void Observe(const splat::DeviceView& view, const splat::DeviceViewWorkspace& workspace, double loss_scale) {
    device_updates::Observe(model_.count, {.rank_of = view.rank_of().data(),
                                           .splats = view.splats().data(),
                                           .cotangents = workspace.splat_sums.data(),
                                           .half_width = static_cast<float>(0.5 * view.pinhole().width / loss_scale),
                                           .half_height = static_cast<float>(0.5 * view.pinhole().height / loss_scale),
                                           .pull = pull_.data(),
                                           .seen = seen_.data()});
  }
  // The parameters, back into the model of the host.
  void DownloadParameters() { x_.CopyTo({model_.data.data(), static_cast<Index>(model_.data.size())}); }
  // Changes model, moments and observations on the host: change() may add and drop Gaussians.
  template <class Change>
  void OnHost(const Change& change) {
    DownloadParameters();
    adam_.first_moments() = Download(first_);
    adam_.second_moments() = Download(second_);
    adam_.set_count(model_.count);
    density_.pull() = Download(pull_);
    density_.seen() = Download(seen_);
    change();
    Upload();
  }

 private:
  void Upload() {
    const auto size = static_cast<Index>(model_.data.size());
    x_.CopyFrom(ViewOf(model_.data));
    units_.CopyFrom(ViewOf(adam_.units()));
    gradient_.Resize(size);
    for (auto [buffer, moments] : {std::pair(&first_, &adam_.first_moments()), {&second_, &adam_.second_moments()}}) {
      if (moments->empty()) {
        buffer->Resize(size);
      } else {
        buffer->CopyFrom(ViewOf(*moments));
      }
    }
    pull_.CopyFrom(ViewOf(density_.pull()));
    seen_.CopyFrom(ViewOf(density_.seen()));
  }

  SplatModel& model_;
  Adam& adam_;
  DensityControl& density_;
  int steps_ = 0;
  DeviceBuffer<float> x_, gradient_, first_, second_, units_, pull_;
  DeviceBuffer<int> seen_;
};

}  // namespace

void RunDeviceAdamStage(TrainingSession& session, SplatModel& model) {
  const TrainOptions& options = session.options();
  const AdamOptions& adam_options = options.adam;
  const int n = adam_options.iterations;
  const std::vector<DeviceTargetView> targets = UploadTargets(LmTargets(session));
  Adam adam(options.rates);
  DensityControl density(options.density, session.scene().extent, options.seed, model.count);
  ViewOrder order(targets.size(), options.seed);
  DevicePhotometricLoss loss({.l1_floor = 0});
  splat::DeviceView view;
  splat::DeviceViewWorkspace workspace;
  DeviceBuffer<float> image, image_gradient;
  const auto measure_units = [&] { adam.SetUnits(TrainingUnits(session, model)); };
  measure_units();
  DeviceModel on_device(model, adam, density);
  double mean_cost = 0;
  const int record_every = std::max(1, n / adam_options.evaluations);

  for (int it = 1; it <= n && !session.stopped(); ++it) {
    const int active_degree = ActiveShDegree(adam_options, model.sh_degree, it);
    const splat::Model<float> x = on_device.kernel_model(active_degree);
    const int attributes = splat::NumAttributes(active_degree);
    const bool observes = options.density.enabled && it <= options.density.end * n;
    double cost = 0, values = 0;
    for (int k = 0; k < adam_options.views_per_iteration; ++k) {
      const DeviceTargetView& target = targets[order.Next()];
      const ImageShape shape = target.shape();
      image.ResizeForOverwrite(shape.NumValues());
      image_gradient.ResizeForOverwrite(shape.NumValues());
      view.Build(x, target.pinhole, options.background.data(), workspace);
      view.Render(image.data());
      loss.Gradient(image, target.truth, shape, image_gradient);
      view.AddJT(x, image.data(), image_gradient.data(), on_device.gradient(), workspace);
      if (observes) on_device.Observe(view, workspace, static_cast<double>(shape.NumValues()));
      // Read last, so that all of the iteration's work is under way.
      cost += loss.Value().objective;
      values += static_cast<double>(shape.NumValues());
    }
    cost /= values;
    on_device.Step(attributes, RateFactor(adam_options, it));

    if (observes && DensifiesAt(options.density, it, n)) {
      on_device.OnHost([&] { density.Densify(model, adam, it), measure_units(); });
    }
    if (observes && ResetsOpacityAt(options.density, it, n)) {
      on_device.OnHost([&] { DensityControl::ResetOpacity(model, adam); });
    }
    mean_cost = it == 1 ? cost : 0.95 * mean_cost + 0.05 * cost;
    const bool is_last = it == n || session.ShouldStop();
    if (is_last || it % record_every == 0) {
      on_device.DownloadParameters();
      session.Record(Stage::kAdam, it, {model.data.data(), model.count, model.sh_degree, active_degree});
    }
    session.Report({Stage::kAdam, it, n, session.Seconds(), mean_cost, session.latest_psnr(), model.count, ""});
  }
}

}  // namespace vesta::gs
