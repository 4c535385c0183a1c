#include "problems/gaussian_splatting/evaluate/device_evaluation.h"

#include "kernels/core/check.h"
#include "kernels/image/device_metrics.h"

namespace vesta::gs {

Evaluation EvaluateOnDevice(const Scene& scene, const std::array<double, 3>& background,
                            const std::vector<TargetView<CudaBackend<float>>>& targets,
                            const splat::Model<float>& model, splat::DeviceViewWorkspace& workspace) {
  EvaluationSum sum;
  DeviceImageQualityMeter meter;
  DevicePhotometricLoss loss;
  splat::DeviceView splats;
  DeviceBuffer<float> rendered, truth;
  auto target = targets.begin();
  for (const View& view : scene.views) {
    const ImageShape shape{view.camera.width, view.camera.height};
    rendered.ResizeForOverwrite(shape.NumValues());
    splats.Build(model, ToPinhole(view, NearPlane(scene)), background.data(), workspace);
    splats.Render(rendered.data());
    double objective = 0;
    if (view.is_test) {
      truth.CopyFrom(HostSpan<const float>(view.image.rgb.data(), shape.NumValues()));
    } else {
      VESTA_CHECK(target != targets.end(), "{} targets are fewer than the training views", targets.size());
      objective = loss.Evaluate(rendered, target->truth, shape).objective;
      // The meter writes into it.
      truth.CopyFrom(Span<const float, Device>(target->truth));
      ++target;
    }
    sum.Add(view, meter.Measure(rendered, truth, shape), objective);
  }
  return sum.Mean();
}

}  // namespace vesta::gs
