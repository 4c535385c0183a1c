// DensityControl in the memory of a GPU: what is observed, what it decides and what follows from that.
#pragma once

#include <algorithm>
#include <cstdint>

#include "kernels/core/device_buffer.h"
#include "kernels/gaussian_splatting/device_view.h"
#include "problems/gaussian_splatting/density/density_formula.h"

namespace vesta::gs {

// How a model is to change: Gaussian i of the new one is first a copy of source[i] of the old one, with its moments
// where kept[i].
struct DensityPlan {
  DeviceBuffer<std::uint32_t> source;
  DeviceBuffer<std::uint8_t> kept;
  DeviceBuffer<Fate> fate;  // by Gaussian of the old model
  Index count = 0;
  bool changes = false;  // without, source is empty: the model stays as it is
};

class DeviceDensityControl {
 public:
  DeviceDensityControl(const DensityOptions& options, double extent, std::uint64_t seed)
      : options_(options), extent_(extent), seed_(seed) {}

  // From now on at most so many, where that is fewer.
  void LimitGaussians(Index most) { options_.max_gaussians = std::min(options_.max_gaussians, most); }
  // Of a model of so many Gaussians from now on, of which nothing was observed.
  void Forget(Index count);
  // As DensityControl::Observe, after DeviceView::AddJT. Does not wait.
  void Observe(const splat::DeviceView& view, const splat::DeviceViewWorkspace& workspace, double loss_scale);
  // As those of DensityControl.
  DeviceBuffer<float>& pull() { return pull_; }
  DeviceBuffer<int>& seen() { return seen_; }
  // What DensityControl::Densify would do to the model x of `count` Gaussians. Waits some times, for numbers of
  // Gaussians; throws OutOfDeviceMemory.
  DensityPlan Decide(const float* x, Index count) const;
  // Makes clones and splits of what are copies so far; x: of the new model. Does not wait.
  void Renew(const DensityPlan& plan, int iteration, float* x) const;

 private:
  DensityOptions options_;
  double extent_;
  std::uint64_t seed_;
  DeviceBuffer<float> pull_;
  DeviceBuffer<int> seen_;
};

}  // namespace vesta::gs
