#include "problems/gaussian_splatting/train/evaluate_or_download.h"

namespace vesta::gs {

Evaluation EvaluateOrDownload(TrainingSession& session, const std::vector<TargetView<CudaBackend<float>>>& targets,
                              const splat::Model<float>& model, splat::DeviceViewWorkspace& workspace,
                              const std::function<splat::Model<float>()>& on_host) {
  try {
    return EvaluateOnDevice(session.scene(), session.options().background, targets, model, workspace);
  } catch (const OutOfDeviceMemory&) {
    return session.Evaluate(on_host());
  }
}

}  // namespace vesta::gs
