// Stage one on a GPU. Parameters, gradient and moments stay in its memory throughout; the host has a copy of them for a
// while after Gaussians have become more.
#include "problems/gaussian_splatting/train/device_adam_stage.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <memory>
#include <optional>

#include "kernels/gaussian_splatting/device_view.h"
#include "kernels/image/device_photometric_loss.h"
#include "problems/gaussian_splatting/adam/schedule.h"
#include "problems/gaussian_splatting/density/density.h"
#include "problems/gaussian_splatting/density/device_density.h"
#include "problems/gaussian_splatting/density/schedule.h"
#include "problems/gaussian_splatting/lm/device_splat_problem.h"
#include "problems/gaussian_splatting/model/length_units.h"
#include "problems/gaussian_splatting/train/coarse_views.h"
#include "problems/gaussian_splatting/train/device_model.h"
#include "problems/gaussian_splatting/train/evaluate_or_download.h"
#include "problems/gaussian_splatting/train/stage_switch.h"

namespace vesta::gs {
namespace {

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
        density_(options_.density, session.scene().extent, options_.seed),
        switch_(options_, static_cast<Index>(session.training_views().size())),
        order_(session.training_views().size(), options_.seed) {}

  // All that is left to do. Throws OutOfDeviceMemory; then what follows may be called.
  void Run() {
    if (targets_.empty()) targets_ = UploadTargets(TargetsOf(session_.training_views(), NearPlane(session_.scene())));
    const Scene& scene = session_.scene();
    on_device_.emplace(model_, adam_, iteration_, density_, UnitViews(session_.training_views(), NearPlane(scene)),
                       scene.extent);
    while (iteration_ < switch_.end() && !session_.stopped()) Iterate();
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
    // What that iteration did besides.
    if (ResetsOpacityAt(options_.density, iteration_, options_.adam.iterations)) {
      DensityControl::ResetOpacity(model_, adam_);
    }
    on_device_.reset();
    passes_ = Passes();
    return true;
  }
  // The model after the last iteration, recorded.
  void Finish() {
    if (on_device_) on_device_->DownloadParameters();
    if (recorded_ != iteration_) session_.Record(Stage::kAdam, iteration_, HostModel());
  }

 private:
  // What the passes over one view work in.
  struct Passes {
    DevicePhotometricLoss loss{{.l1_floor = 0}};
    splat::DeviceView view;
    splat::DeviceViewWorkspace workspace;
    DeviceBuffer<float> image, image_gradient;
  };

  int ActiveDegree() const { return ActiveShDegree(options_.adam, model_.sh_degree, iteration_); }
  splat::Model<float> HostModel() const { return {model_.data.data(), model_.count, model_.sh_degree, ActiveDegree()}; }

  void Record() {
    const std::function<splat::Model<float>()> on_host = [&] {
      on_device_->DownloadParameters();
      return HostModel();
    };
    const auto evaluate = [&] {
      return EvaluateOrDownload(session_, targets_, on_device_->result(ActiveDegree()), passes_.workspace, on_host);
    };
    session_.Record(Stage::kAdam, iteration_, ModelToRecord{model_.count, evaluate, on_host});
    recorded_ = iteration_;
  }

  // What iteration `it` trains on.
  const std::vector<TargetView<CudaBackend<float>>>& TargetsAt(int it) {
    const bool is_coarse = IsCoarseAt(options_.adam, it);
    if (!is_coarse) coarse_targets_.clear();
    if (is_coarse && coarse_targets_.empty() && !lacks_halves_) {
      const std::vector<View> views = CoarseViews(session_.training_views());
      lacks_halves_ = views.empty();
      std::vector<const View*> pointers;
      pointers.reserve(views.size());
      for (const View& view : views) pointers.push_back(&view);
      coarse_targets_ = UploadTargets(TargetsOf(pointers, NearPlane(session_.scene())));
    }
    return coarse_targets_.empty() ? targets_ : coarse_targets_;
  }

  // The mean cost of some views a value; their gradients are added to the model's.
  double AddGradients(const splat::Model<float>& x, const std::vector<TargetView<CudaBackend<float>>>& targets,
                      bool observes) {
    double cost = 0, values = 0;
    for (int k = 0; k < options_.adam.views_per_iteration; ++k) {
      const std::size_t next = order_.Next();
      const TargetView<CudaBackend<float>>& target = targets[next];
      const ImageShape shape = target.shape();
      passes_.image.ResizeForOverwrite(shape.NumValues());
      passes_.image_gradient.ResizeForOverwrite(shape.NumValues());
      passes_.view.Build(x, target.pinhole, options_.background.data(), passes_.workspace);
      passes_.view.Render(passes_.image.data());
      passes_.loss.Gradient(passes_.image, target.truth, shape, passes_.image_gradient);
      passes_.view.AddJT(x, passes_.image.data(), passes_.image_gradient.data(), on_device_->gradient(),
                         passes_.workspace);
      if (observes) {
        const double share = PullShare(shape.width, targets_[next].pinhole.width);
        density_.Observe(passes_.view, passes_.workspace, share * static_cast<double>(shape.NumValues()));
      }
      // Read last, so that all of the iteration's work is under way.
      cost += passes_.loss.Value().objective;
      values += static_cast<double>(shape.NumValues());
    }
    return cost / values;
  }

  void Iterate() {
    const int n = options_.adam.iterations, it = iteration_ + 1;
    const int active_degree = ActiveShDegree(options_.adam, model_.sh_degree, it);
    const bool observes = options_.density.enabled && it <= options_.density.end * n;
    const double cost = AddGradients(on_device_->kernel_model(active_degree), TargetsAt(it), observes);
    on_device_->Step(splat::NumAttributes(active_degree), RateFactor(options_.adam, it, switch_.end()));
    switch_.Observe(it, cost);
    iteration_ = it;
    mean_cost_ = it == 1 ? cost : 0.95 * mean_cost_ + 0.05 * cost;
    // Once every view has been through with the Gaussians there are, there is room for them.
    if (before_growth_ && (it - before_growth_->iteration) * options_.adam.views_per_iteration >= 2 * NumViews()) {
      before_growth_.reset();
    }
    if (averages_ && AveragesAt(options_.adam, it, switch_.end())) Average();
    const bool is_last = it == switch_.end() || session_.ShouldStop();
    if (is_last || it % std::max(1, n / options_.adam.evaluations) == 0) Record();
    if (is_last) on_device_->DownloadParameters();
    if (observes && !is_last) {
      if (DensifiesAt(options_.density, it, n)) Densify();
      if (ResetsOpacityAt(options_.density, it, n)) on_device_->ResetOpacity();
    }
    session_.Report(
        {Stage::kAdam, it, switch_.end(), session_.Seconds(), mean_cost_, session_.latest_psnr(), model_.count, ""});
  }

  // The mean is an improvement; for want of its room training does not end.
  void Average() {
    try {
      on_device_->Average();
    } catch (const OutOfDeviceMemory& error) {
      averages_ = false;
      session_.Note(fmt::format("Adam leaves its last parameters, not their mean: {}", error.what()));
    }
  }

  void Densify() {
    passes_ = Passes();  // the new bases need room while the old ones are there
    on_device_->Densify(iteration_, [&] {
      on_device_->DownloadParameters();
      before_growth_ = AdamState{model_, on_device_->DownloadAdam(), iteration_, mean_cost_};
    });
  }

  int NumViews() const { return static_cast<int>(targets_.size()); }

  TrainingSession& session_;
  const TrainOptions& options_;
  SplatModel& model_;
  Adam adam_;
  DeviceDensityControl density_;
  StageSwitch switch_;
  ViewOrder order_;
  std::vector<TargetView<CudaBackend<float>>> targets_, coarse_targets_;
  bool lacks_halves_ = false, averages_ = true;
  Passes passes_;
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
