// SPDX-License-Identifier: Apache-2.0
// A scene in a view on the device, with the interface of test::RenderedView and host vectors.
#pragma once

#include "kernels/gaussian_splatting/device/device_splat_view.h"
#include "tests/cuda/on_device.h"
#include "tests/support/splat_scenes.h"

namespace vesta::test {

struct DeviceRenderedView {
  using Scalar = float;
  DeviceBuffer<float> x, device_image;
  splat::Model<float> model;
  splat::DeviceSplatView view;
  splat::DeviceViewWorkspace workspace;
  std::vector<float> image;

  explicit DeviceRenderedView(const Scene& scene)
      : x(ToDevice(std::vector<float>(scene.x.begin(), scene.x.end()))),
        model{x.data(), scene.layout(), scene.active_sh_degree} {
    view.Build(model, scene.view, scene.background, workspace);
    device_image.Resize(3 * view.num_pixels());
    view.Render(device_image.data());
    image = ToHost(device_image);
  }
  std::vector<float> ApplyJ(const std::vector<float>& dx) {
    const DeviceBuffer<float> on_device = ToDevice(dx);
    DeviceBuffer<float> d_image(device_image.size());
    view.ApplyJ(model, on_device.data(), d_image.data(), workspace);
    return ToHost(d_image);
  }
  std::vector<float> ApplyJT(const std::vector<float>& u) {
    const DeviceBuffer<float> on_device = ToDevice(u);
    DeviceBuffer<float> g(x.size());
    view.AddJT(model, device_image.data(), on_device.data(), g.data(), workspace);
    return ToHost(g);
  }
  std::vector<float> Gram(const std::vector<float>& omega) {
    const DeviceBuffer<float> on_device = ToDevice(omega);
    const Index blocks = Index{splat::kGeometry * (splat::kGeometry + 1) / 2} * model.count;
    DeviceBuffer<float> gram(blocks + x.size() - splat::kSh * model.count);
    view.AddGram(model, device_image.data(), on_device.data(), gram.data(), gram.data() + blocks, workspace);
    return ToHost(gram);
  }
  Index num_splats() const { return view.num_splats(); }
  std::vector<std::int32_t> rank_of() const {
    std::vector<std::int32_t> ranks(static_cast<std::size_t>(model.count));
    DeviceBuffer<std::int32_t> copy;
    copy.CopyFrom(view.rank_of());
    copy.CopyTo({ranks.data(), model.count});
    return ranks;
  }
};

}  // namespace vesta::test
