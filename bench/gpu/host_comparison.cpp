// SPDX-License-Identifier: Apache-2.0
#include "bench/gpu/host_comparison.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <vector>

#include "kernels/core/random.h"
#include "kernels/gaussian_splatting/device/device_splat_view.h"
#include "kernels/gaussian_splatting/view/splat_view.h"
#include "problems/gaussian_splatting/model/targets.h"

namespace vesta::bench {
namespace {

constexpr double kBackground[3] = {0.1, 0.2, 0.3};

std::vector<float> Normals(std::size_t size, std::uint64_t key) {
  CounterRandom random(11, key);
  std::vector<float> values(size);
  for (float& value : values) value = static_cast<float>(random.Normal());
  return values;
}

HostSpan<const float> ViewOf(const std::vector<float>& v) { return {v.data(), static_cast<Index>(v.size())}; }

// Image, J v, J^T u.
using Results = std::array<std::vector<float>, 3>;

Results OnHost(const Workload& workload, const std::vector<float>& v, const std::vector<float>& u) {
  Results results = {std::vector<float>(u.size()), std::vector<float>(u.size()), std::vector<float>(v.size())};
  auto& [image, j_v, jt_u] = results;
  const splat::Model<float> model = gs::ToKernelModel(workload.model);
  splat::ViewWorkspace<float> workspace;
  splat::SplatView<float> view;
  view.Build(model, workload.views.front(), kBackground, workspace);
  view.Render(image.data());
  view.ApplyJ(model, v.data(), j_v.data(), workspace);
  view.AddJT(model, image.data(), u.data(), jt_u.data(), workspace);
  return results;
}

Results OnDevice(const Workload& workload, const std::vector<float>& v, const std::vector<float>& u) {
  Results results = {std::vector<float>(u.size()), std::vector<float>(u.size()), std::vector<float>(v.size())};
  DeviceBuffer<float> x, dv, du;
  x.CopyFrom(ViewOf(workload.model.data));
  dv.CopyFrom(ViewOf(v));
  du.CopyFrom(ViewOf(u));
  const splat::Model<float> model = {x.data(), workload.model.count, workload.model.sh_degree,
                                     workload.model.sh_degree};
  DeviceBuffer<float> image(du.size()), j_v(du.size()), jt_u(x.size());
  splat::DeviceViewWorkspace workspace;
  splat::DeviceSplatView view;
  view.Build(model, workload.views.front(), kBackground, workspace);
  view.Render(image.data());
  view.ApplyJ(model, dv.data(), j_v.data(), workspace);
  view.AddJT(model, image.data(), du.data(), jt_u.data(), workspace);
  const auto read = [](const DeviceBuffer<float>& from, std::vector<float>& to) {
    from.CopyTo({to.data(), from.size()});
  };
  read(image, results[0]), read(j_v, results[1]), read(jt_u, results[2]);
  return results;
}

double RelativeDifference(const std::vector<float>& found, const std::vector<float>& expected) {
  double difference = 0, size = 0;
  for (std::size_t i = 0; i < expected.size(); ++i) {
    difference += std::pow(double{found[i]} - double{expected[i]}, 2);
    size += std::pow(double{expected[i]}, 2);
  }
  return std::sqrt(difference / size);
}

}  // namespace

HostComparison CompareWithHost(const Workload& workload) {
  const std::vector<float> v = Normals(workload.model.data.size(), 1),
                           u = Normals(static_cast<std::size_t>(workload.shape().NumValues()), 2);
  const Results device = OnDevice(workload, v, u);
  HostComparison comparison;
  {
    const Results again = OnDevice(workload, v, u);
    for (std::size_t k = 0; k < device.size(); ++k) {
      for (std::size_t i = 0; i < device[k].size(); ++i) {
        const auto bits = [&](const Results& of) { return std::bit_cast<std::uint32_t>(of[k][i]); };
        comparison.differing += bits(device) != bits(again) ? 1 : 0;
      }
    }
  }
  const Results host = OnHost(workload, v, u);
  comparison.image = RelativeDifference(device[0], host[0]);
  comparison.j_v = RelativeDifference(device[1], host[1]);
  comparison.jt_u = RelativeDifference(device[2], host[2]);
  return comparison;
}

}  // namespace vesta::bench
