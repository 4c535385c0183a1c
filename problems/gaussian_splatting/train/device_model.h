// A model in the memory of a GPU while Adam trains it, with all that goes with each Gaussian.
#pragma once

#include <functional>
#include <vector>

#include "kernels/core/cuda_backend.h"
#include "kernels/core/device_buffer.h"
#include "problems/gaussian_splatting/adam/device_adam.h"
#include "problems/gaussian_splatting/adam/parameter_mean.h"
#include "problems/gaussian_splatting/density/device_density.h"

namespace vesta::gs {

class DeviceModel {
 public:
  // Of the host's model, which must outlive this, as must all that is referred to: its count is kept up, its data are
  // those of the last download. Adam's moments go to the GPU; steps: that it has done. unit_views: UnitViews; unit: of
  // Gaussians that none of them sees. What `density` has observed is forgotten.
  DeviceModel(SplatModel& model, Adam& adam, int steps, DeviceDensityControl& density,
              const std::vector<splat::PinholeView>& unit_views, double unit);

  splat::Model<float> kernel_model(int active_sh_degree) const { return AsModel(x_, active_sh_degree); }
  // The mean of the parameters that were averaged, where there is one.
  splat::Model<float> result(int active_sh_degree) const { return AsModel(Result(), active_sh_degree); }
  float* gradient() { return gradient_.data(); }

  // As Adam::Step by the gradient.
  void Step(int attributes, double factor) {
    adam_.Step(model_.count, x_.data(), gradient_.data(), attributes, factor);
  }
  // Counts the parameters in their mean, until Gaussians change.
  void Average() { average_.Add(x_); }
  // As DensityControl::Densify, with new units of length. before_growth is called before Gaussians become more, and
  // only then. Throws OutOfDeviceMemory: where Gaussians have not become more, what can be downloaded is the model of
  // before or of after.
  void Densify(int iteration, const std::function<void()>& before_growth);
  // As DensityControl::ResetOpacity.
  void ResetOpacity();

  // The parameters of result(), into the model of the host.
  void DownloadParameters();
  Adam DownloadAdam() const { return adam_.Download(model_.count); }

 private:
  // What begins anew with each change of the model.
  void StartAnew();
  void Rearrange(const DensityPlan& plan, int iteration);
  const DeviceBuffer<float>& Result() const { return average_.empty() ? x_ : average_.value(); }
  splat::Model<float> AsModel(const DeviceBuffer<float>& x, int active_sh_degree) const {
    return {x.data(), model_.count, model_.sh_degree, active_sh_degree};
  }

  SplatModel& model_;
  DeviceDensityControl& density_;
  DeviceAdam adam_;
  DeviceBuffer<float> x_, gradient_;
  ParameterMean<CudaBackend<float>> average_;
  DeviceBuffer<splat::PinholeView> unit_views_;
  double unit_;
};

}  // namespace vesta::gs
