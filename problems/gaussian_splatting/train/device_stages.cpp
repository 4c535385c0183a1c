#include "problems/gaussian_splatting/train/device_stages.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "kernels/core/check.h"
#include "problems/gaussian_splatting/lm/splat_problem.h"
#include "problems/gaussian_splatting/model/device_splat_backend.h"
#include "problems/gaussian_splatting/train/adam_stage.h"
#include "problems/gaussian_splatting/train/evaluate_or_download.h"
#include "problems/gaussian_splatting/train/lm_steps.h"

namespace vesta::gs {

extern template void RunAdamStage<CudaBackend<float>>(TrainingSession& session, SplatModel& model);

namespace {

// Adds what a stepper has done to a total, also where it ends by an exception.
class CountDone {
 public:
  CountDone(const LmStepper<CudaBackend<float>>& stepper, int& total) : stepper_(stepper), total_(total) {}
  ~CountDone() { total_ += stepper_.summary().num_accepted + stepper_.summary().num_rejected; }
  CountDone(const CountDone&) = delete;
  CountDone& operator=(const CountDone&) = delete;

 private:
  const LmStepper<CudaBackend<float>>& stepper_;
  int& total_;
};

DeviceBuffer<float> Uploaded(const SplatModel& model) {
  DeviceBuffer<float> x;
  x.CopyFrom(HostSpan<const float>(model.data.data(), static_cast<Index>(model.data.size())));
  return x;
}

// Where the GPU's memory does not suffice after all (the plan counts some views only, and others may use it) the stage
// goes on from its best model with batches of half the size, solved one by one and merged, so that one of them is in
// memory at a time.
std::string RunDeviceLmStage(TrainingSession& session, SplatModel& model, bool hold_batches) {
  using B = CudaBackend<float>;
  std::vector<TargetView<CudaBackend<float>>> targets;
  LmStart start(session, model);
  SplatProblemOptions problem_options = LmProblemOptions(session, model, start.shape.units);
  vesta::LmOptions engine_options = LmEngineOptions(session.options().lm);
  engine_options.hold_batches = hold_batches;
  const int views = static_cast<int>(session.training_views().size());
  int& done = start.shape.done;
  bool resumes = start.saved();
  for (;;) {
    try {
      if (targets.empty())
        targets = TargetsIn<CudaBackend<float>>(TargetsOf(session.training_views(), NearPlane(session.scene())));
      B backend;
      SplatProblem<CudaBackend<float>> problem(problem_options, targets);
      engine_options.max_iterations = session.options().lm.iterations - done;
      LmStepper<B> stepper = std::exchange(resumes, false)
                                 ? LmStepper<B>(engine_options, backend, problem, start.solve())
                                 : LmStepper<B>(engine_options, backend, problem, Uploaded(model));
      const CountDone count(stepper, done);
      const auto on_host = [&] { return ToKernelModel(model); };
      const auto evaluate = [&] {
        return EvaluateOrDownload(session, targets, BestOf(stepper, model), problem.workspace(), on_host);
      };
      return RunLmSteps(session, stepper, start.shape, {model.count, evaluate, on_host}, [&] {
        backend.ToHost(stepper.x(), {model.data.data(), static_cast<Index>(model.data.size())});
      });
    } catch (const OutOfDeviceMemory& error) {
      if (problem_options.batches.count >= views) {
        if (done == 0 && session.options().adam.iterations == 0) throw;
        session.Note(fmt::format("LM ends after {} iterations: {}", done, error.what()));
        return "";
      }
      problem_options.batches.count = std::min(views, 2 * problem_options.batches.count);
      problem_options.batches.size = 0;
      engine_options.batch_mode = BatchMode::kMerge;
      engine_options.hold_batches = false;
      session.Note(fmt::format("LM goes on in {} batches: {}", problem_options.batches.count, error.what()));
    }
  }
}

}  // namespace

StageRunners DeviceStages() {
  const DeviceInfo& device = QueryDevice();
  if (!device.usable) Fail("--device=cuda: no GPU to use ({}); choose --device=cpu", device.name);
  device::ResetPeak();
  return {"cuda", RunAdamStage<CudaBackend<float>>, RunDeviceLmStage, [] {
            return DeviceMemoryUse{static_cast<double>(device::FreeBytes()), static_cast<double>(device::PeakBytes())};
          }};
}

}  // namespace vesta::gs
