// Stage one on a GPU. Parameters, gradient and moments stay in its memory between changes of the model's size, which
// happen on the host.
#include "problems/gaussian_splatting/train/device_adam_stage.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <optional>

#include "kernels/gaussian_splatting/device_view.h"
#include "kernels/image/device_photometric_loss.h"
#include "problems/gaussian_splatting/lm/device_splat_problem.h"
#include "problems/gaussian_splatting/train/adam_schedule.h"
#include "problems/gaussian_splatting/train/density.h"
#include "problems/gaussian_splatting/train/device_adam.h"
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
  // steps: of Adam that were done before.
  DeviceModel(SplatModel& model, Adam& adam, DensityControl& density, int steps)
      : model_(model), density_(density), adam_(adam, steps) {
    Upload();
  }

  splat::Model<float> kernel_model(int active_sh_degree) const {
    return {x_.data(), model_.count, model_.sh_degree, active_sh_degree};
  }
  float* gradient() { return gradient_.data(); }

  void Step(int attributes, double factor) {
    adam_.Step(model_.count, x_.data(), gradient_.data(), attributes, factor);
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
    adam_.Download();
    density_.pull() = Download(pull_);
    density_.seen() = Download(seen_);
    change();
    Upload();
  }

 private:
  void Upload() {
    const auto size = static_cast<Index>(model_.data.size());
    x_.CopyFrom(ViewOf(model_.data));
    gradient_.Resize(size);
    adam_.Upload(model_);
    pull_.CopyFrom(ViewOf(density_.pull()));
    seen_.CopyFrom(ViewOf(density_.seen()));
  }

  SplatModel& model_;
  DensityControl& density_;
  DeviceAdam adam_;
  DeviceBuffer<float> x_, gradient_, pull_;
  DeviceBuffer<int> seen_;
};

// Where the stage stands, on the host.
struct AdamState {
  SplatModel model;
  Adam adam;
  int iteration = 0;
  double mean_cost = 0;
};

class DeviceAdamStage {
 public:
  DeviceAdamStage(TrainingSession& session, SplatModel& model)
      : session_(session),
        options_(session.options()),
        model_(model),
        adam_(options_.rates, MetricOf(options_.adam)),
        density_(options_.density, session.scene().extent, options_.seed, model.count),
        order_(session.training_views().size(), options_.seed) {
    MeasureUnits();
  }

  // All that is left to do. Throws OutOfDeviceMemory; then what follows may be called.
  void Run() {
    if (targets_.empty()) targets_ = UploadTargets(LmTargets(session_));
    Passes passes;
    on_device_.emplace(model_, adam_, density_, iteration_);
    while (iteration_ < options_.adam.iterations && !session_.stopped()) Iterate(passes);
  }

  int iteration() const { return iteration_; }
  // Back to before the Gaussians last became more, to go on without. False where there is no such state.
  bool GoBackBeforeGrowth() {
    if (!before_growth_) return false;
    model_ = std::move(before_growth_->model);
    adam_ = std::move(before_growth_->adam);
    iteration_ = before_growth_->iteration;
    mean_cost_ = before_growth_->mean_cost;
    before_growth_.reset();
    density_.LimitGaussians(model_.count);
    density_.Forget(model_.count);
    // What that iteration did besides.
    if (ResetsOpacityAt(options_.density, iteration_, options_.adam.iterations)) {
      DensityControl::ResetOpacity(model_, adam_);
    }
    on_device_.reset();
    return true;
  }
  // The model after the last iteration, recorded.
  void Finish() {
    if (on_device_) on_device_->DownloadParameters();
    if (recorded_ != iteration_) Record();
  }

 private:
  // What the passes over one view work in.
  struct Passes {
    DevicePhotometricLoss loss{{.l1_floor = 0}};
    splat::DeviceView view;
    splat::DeviceViewWorkspace workspace;
    DeviceBuffer<float> image, image_gradient;
  };

  void MeasureUnits() { adam_.SetUnits(TrainingUnits(session_, model_)); }

  void Record() {
    const int degree = ActiveShDegree(options_.adam, model_.sh_degree, iteration_);
    session_.Record(Stage::kAdam, iteration_, {model_.data.data(), model_.count, model_.sh_degree, degree});
    recorded_ = iteration_;
  }

  // The mean cost of some views a value; their gradients are added to the model's.
  double AddGradients(Passes& passes, const splat::Model<float>& x, bool observes) {
    double cost = 0, values = 0;
    for (int k = 0; k < options_.adam.views_per_iteration; ++k) {
      const DeviceTargetView& target = targets_[order_.Next()];
      const ImageShape shape = target.shape();
      passes.image.ResizeForOverwrite(shape.NumValues());
      passes.image_gradient.ResizeForOverwrite(shape.NumValues());
      passes.view.Build(x, target.pinhole, options_.background.data(), passes.workspace);
      passes.view.Render(passes.image.data());
      passes.loss.Gradient(passes.image, target.truth, shape, passes.image_gradient);
      passes.view.AddJT(x, passes.image.data(), passes.image_gradient.data(), on_device_->gradient(), passes.workspace);
      if (observes) on_device_->Observe(passes.view, passes.workspace, static_cast<double>(shape.NumValues()));
      // Read last, so that all of the iteration's work is under way.
      cost += passes.loss.Value().objective;
      values += static_cast<double>(shape.NumValues());
    }
    return cost / values;
  }

  void Iterate(Passes& passes) {
    const int n = options_.adam.iterations, it = iteration_ + 1;
    const int active_degree = ActiveShDegree(options_.adam, model_.sh_degree, it);
    const bool observes = options_.density.enabled && it <= options_.density.end * n;
    const double cost = AddGradients(passes, on_device_->kernel_model(active_degree), observes);
    on_device_->Step(splat::NumAttributes(active_degree), RateFactor(options_.adam, it));
    iteration_ = it;
    mean_cost_ = it == 1 ? cost : 0.95 * mean_cost_ + 0.05 * cost;
    // Once every view has been through with the Gaussians there are, there is room for them.
    if (before_growth_ && (it - before_growth_->iteration) * options_.adam.views_per_iteration >= 2 * NumViews()) {
      before_growth_.reset();
    }
    if (observes && DensifiesAt(options_.density, it, n)) on_device_->OnHost([&] { Densify(); });
    if (observes && ResetsOpacityAt(options_.density, it, n)) {
      on_device_->OnHost([&] { DensityControl::ResetOpacity(model_, adam_); });
    }
    const bool is_last = it == n || session_.ShouldStop();
    if (is_last || it % std::max(1, n / options_.adam.evaluations) == 0) {
      on_device_->DownloadParameters();
      Record();
    }
    session_.Report({Stage::kAdam, it, n, session_.Seconds(), mean_cost_, session_.latest_psnr(), model_.count, ""});
  }

  void Densify() {
    AdamState before{model_, adam_, iteration_, mean_cost_};
    density_.Densify(model_, adam_, iteration_);
    if (model_.count > before.model.count) before_growth_ = std::move(before);
    MeasureUnits();
  }

  int NumViews() const { return static_cast<int>(targets_.size()); }

  TrainingSession& session_;
  const TrainOptions& options_;
  SplatModel& model_;
  Adam adam_;
  DensityControl density_;
  ViewOrder order_;
  std::vector<DeviceTargetView> targets_;
  std::optional<DeviceModel> on_device_;
  std::optional<AdamState> before_growth_;
  int iteration_ = 0, recorded_ = 0;
  double mean_cost_ = 0;
};

}  // namespace

void RunDeviceAdamStage(TrainingSession& session, SplatModel& model) {
  for (auto stage = std::make_unique<DeviceAdamStage>(session, model);;) {
    try {
      return stage->Run();
    } catch (const OutOfDeviceMemory& error) {
      const int failed = stage->iteration();
      if (stage->GoBackBeforeGrowth()) {
        session.Note(fmt::format("Adam goes on from iteration {} with {} Gaussians and no more: {}", stage->iteration(),
                                 model.count, error.what()));
      } else if (failed > 0) {
        session.Note(fmt::format("Adam ends after {} iterations: {}", failed, error.what()));
        return stage->Finish();
      } else {
        session.Note(fmt::format("Adam runs on the CPU: {}", error.what()));
        stage.reset();
        return RunAdamStage(session, model);
      }
    }
  }
}

}  // namespace vesta::gs
