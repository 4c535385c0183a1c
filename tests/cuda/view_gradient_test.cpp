// SPDX-License-Identifier: Apache-2.0
// Per-view gradients on the GPU have the host's bits.
#include <vector>

#include "kernels/core/device_buffer.h"
#include "kernels/core/device_sort.h"
#include "splatting/distributed/sum_of_views.h"
#include "tests/cuda/on_device.h"
#include "tests/splatting/train/synthetic_views.h"

namespace vesta::gs {
namespace {

template <class T, class Space>
Buffer<T, Space> CopyOf(const std::vector<T>& values) {
  Buffer<T, Space> buffer;
  buffer.CopyFrom(HostSpan<const T>(values.data(), static_cast<Index>(values.size())));
  return buffer;
}
template <class T>
std::vector<T> OnHost(const HostBuffer<T>& buffer) {
  return {buffer.begin(), buffer.end()};
}
template <class T>
std::vector<T> OnHost(const DeviceBuffer<T>& buffer) {
  return vesta::test::ToHost(buffer);
}

struct Learned {
  std::vector<float> gradient, pull;
  Index views = 0;
  double objective = 0;
};

template <class Space>
Learned Learn(const test::SyntheticViews& all) {
  SumOfViews<Space> sum;
  DensityControl<Space> density({}, 1);
  density.ResetStatistics(all.gaussians());
  sum.Begin(all.layout, static_cast<Index>(all.views.size()), &density);
  Buffer<float, Space> gradient;
  for (std::size_t k = 0; k < all.views.size(); ++k) {
    const test::SyntheticViews::View& view = all.views[k];
    gradient = CopyOf<float, Space>(view.gradient);
    const auto rank_of = CopyOf<std::int32_t, Space>(view.rank_of);
    const auto splats = CopyOf<splat::Splat<float>, Space>(view.splats);
    const auto cotangents = CopyOf<splat::SplatTangent<float>, Space>(view.cotangents);
    density::PullView pull_view = view.pull_view();
    pull_view.rank_of = rank_of.data(), pull_view.splats = splats.data(), pull_view.cotangents = cotangents.data();
    sum.Add(static_cast<Index>(k), pull_view, gradient.data(), [&] { return view.cost; });
  }
  Learned learned;
  learned.objective = sum.Finish(gradient.data()).objective;
  learned.gradient = OnHost(gradient), learned.pull = OnHost(density.pull()), learned.views = density.views();
  return learned;
}

class CudaViewGradients : public vesta::test::OnDevice {};

TEST_F(CudaViewGradients, AddUpAsOnTheHost) {
  for (const int views : {2, 5, 8}) {
    const test::SyntheticViews all(views);
    const Learned host = Learn<Host>(all), device = Learn<Device>(all);
    EXPECT_EQ(device.gradient, host.gradient) << views;
    EXPECT_EQ(device.views, views);
    EXPECT_EQ(host.views, views);
    EXPECT_EQ(device.objective, host.objective) << views;
    // Products and sums on the device may round differently.
    ASSERT_EQ(device.pull.size(), host.pull.size());
    for (std::size_t i = 0; i < host.pull.size(); ++i) {
      EXPECT_NEAR(device.pull[i], host.pull[i], 1e-5 * host.pull[i]);
    }
  }
}

}  // namespace
}  // namespace vesta::gs
