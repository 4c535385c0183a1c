// SPDX-License-Identifier: Apache-2.0
// Density control on the GPU and on the host.
#include "splatting/density/density.h"

#include <optional>
#include <string>

#include "kernels/core/archive.h"
#include "kernels/core/cuda_backend.h"
#include "kernels/core/device_sort.h"
#include "kernels/gaussian_splatting/device/device_splat_view.h"
#include "problems/gaussian_splatting/model/length_units.h"
#include "splatting/adam/device_adam_steps.h"
#include "splatting/evaluate/evaluation.h"
#include "splatting/train/adam_stage/trained_model.h"
#include "tests/cuda/on_device.h"
#include "tests/splatting/density/density_scene.h"
#include "tests/support/random.h"

namespace vesta::gs {
namespace {

constexpr double kExtent = 2, kNear = 0.02;
constexpr std::uint64_t kSeed = 5;
constexpr int kSteps = 7, kIteration = 40;

std::vector<std::uint8_t> DegreesOf(Index count) {
  std::vector<std::uint8_t> degrees;
  degrees.reserve(static_cast<std::size_t>(count));
  for (Index i = 0; i < count; ++i) degrees.push_back(static_cast<std::uint8_t>(i * i % 4));
  return degrees;
}
SplatModel OfDifferentDegrees(Index count) {
  return test::WithDegrees(test::RandomModel(count, 3, 5), DegreesOf(count));
}

struct Case {
  const char* name;
  Index gaussians;
  void (*apply)(DensityOptions&);
  void (*change)(SplatModel&);
  Index after = 0;  // expected Gaussians; 0: any
};
const Case kCases[] = {
    {"clones_splits_and_prunes", 300, [](DensityOptions&) {}, [](SplatModel&) {}},
    // The limit falls between equal gradients.
    {"cap", 300, [](DensityOptions& o) { o.max_gaussians = 250; }, [](SplatModel&) {}, 250},
    {"no_room", 300, [](DensityOptions& o) { o.max_gaussians = 10; }, [](SplatModel&) {}},
    {"all_split", 3, [](DensityOptions& o) { o.grow_scale3d = 1e-6, o.grow_grad2d = 0, o.prune_opa = 0; },
     [](SplatModel&) {}, 6},
    {"huge_ones", 300, [](DensityOptions& o) { o.prune_scale3d = 0.06; }, [](SplatModel&) {}},
    {"nothing_to_do", 40, [](DensityOptions& o) { o.grow_grad2d = 100, o.prune_opa = 0; }, [](SplatModel&) {}, 40},
    {"all_transparent", 40, [](DensityOptions&) {},
     [](SplatModel& m) { std::fill_n(m.attribute(splat::kOpacity), m.count, -9.0f); }},
    {"different_degrees", 300, [](DensityOptions&) {}, [](SplatModel& m) { m = OfDifferentDegrees(m.count); }},
    // exp of this logit overflows in float.
    {"opaque_ones", 40, [](DensityOptions& o) { o.grow_grad2d = 0, o.grow_scale3d = 1; },
     [](SplatModel& m) { std::fill_n(m.attribute(splat::kOpacity), m.count, 200.0f); }},
};

// The same model in training on the host and on the GPU.
class Both {
 public:
  Both(const Case& c, SecondMoment metric) {
    for (const View& view : scene_.views) views_.push_back(&view);
    SplatModel model = test::RandomModel(c.gaussians, 1, 5);
    c.change(model);
    host_.emplace(Start<CpuBackend<float>>(c, metric, model));
    for (int step = 0; step < kSteps; ++step) StepHost();
    // The optimiser state.
    std::string bytes;
    ArchiveWriter([&](std::string_view piece) { bytes.append(piece); })(host_->adam());
    host_->DownloadResult(model);
    device_.emplace(Start<CudaBackend<float>>(c, metric, model));
    ArchiveReader device_reader(bytes);
    device_reader(device_->adam());
    host_.emplace(Start<CpuBackend<float>>(c, metric, model));
    ArchiveReader reader(bytes);
    reader(host_->adam());
    // With many equal values and some unobserved Gaussians.
    std::vector<float> grad2d;
    std::vector<int> seen;
    for (Index i = 0; i < c.gaussians; ++i) {
      const Index times = (i + 1) % 4, strength = 15 + (7 * i + 3) % 31 / 8;
      seen.push_back(static_cast<int>(times));
      grad2d.push_back(1e-4f * static_cast<float>(times * strength));
    }
    host_->density().grad2d().CopyFrom(vesta::test::ViewOf(grad2d));
    host_->density().seen().CopyFrom(vesta::test::ViewOf(seen));
    device_->density().grad2d().CopyFrom(vesta::test::ViewOf(grad2d));
    device_->density().seen().CopyFrom(vesta::test::ViewOf(seen));
  }

  void Densify() {
    const Index before = host_->count();
    for (const bool on_device : {false, true}) {
      Index called_with = -1;
      if (on_device) {
        device_->Densify(kIteration, [&] { called_with = device_->count(); });
      } else {
        host_->Densify(kIteration, [&] { called_with = host_->count(); });
      }
      EXPECT_EQ(called_with, host_->count() > before ? before : -1);
    }
  }
  void ResetOpacity() {
    host_->ResetOpacity();
    device_->ResetOpacity();
  }
  // A step on both with the same gradient, learning rates of a new model, and units.
  void Step() {
    const std::vector<float> gradient = StepHost();
    const int attributes = splat::NumAttributes(device_->sh_degree());
    DeviceBuffer<float> on_device = vesta::test::ToDevice(gradient);
    device::Copy(device_->gradient(attributes), on_device.data(), gradient.size() * sizeof(float));
    device_->Step(attributes, 1);
  }

  void SetDegrees(const std::vector<std::uint8_t>& degrees) {
    host_->SetDegrees(degrees);
    device_->SetDegrees(degrees);
    EXPECT_EQ(vesta::test::ToHost(device_->density().seen()),
              std::vector<int>(host_->density().seen().begin(), host_->density().seen().end()));
  }

  Index gaussians() const { return host_->count(); }
  void ExpectTheSame(double tolerance) {
    SplatModel host, device;
    host_->DownloadResult(host);
    device_->DownloadResult(device);
    ASSERT_EQ(device.layout(), host.layout());
    ASSERT_EQ(device.data.size(), host.data.size());
    // Copied values are bit-identical; exp, log and cos may differ by rounding.
    if (tolerance == 0) {
      for (int a = splat::kQuaternion; a < host.num_attributes(); ++a) {
        if (a == splat::kOpacity) continue;
        for (Index i = 0; i < host.Rows(a); ++i) ASSERT_EQ(device.attribute(a)[i], host.attribute(a)[i]) << a << i;
      }
    }
    EXPECT_LT(vesta::test::RelativeError(device.data, host.data), std::max(tolerance, 1e-6));
    const auto expect_same = [&](const std::vector<float>& found, const HostBuffer<float>& expected) {
      ASSERT_EQ(static_cast<Index>(found.size()), expected.size());
      if (tolerance == 0) {
        EXPECT_TRUE(std::equal(found.begin(), found.end(), expected.begin()));
      } else if (!expected.empty()) {
        EXPECT_LT(vesta::test::RelativeError(found, expected), tolerance);
      }
    };
    expect_same(vesta::test::ToHost(device_->adam().first()), host_->adam().first());
    expect_same(vesta::test::ToHost(device_->adam().second()), host_->adam().second());
    const HostBuffer<float> bases = device_->adam().bases().OnHost(device.count).Flat();
    expect_same({bases.begin(), bases.end()}, host_->adam().bases().Flat());
  }

 private:
  template <class B>
  TrainedModel<B> Start(const Case& c, SecondMoment metric, const SplatModel& model) const {
    DensityOptions options;
    options.grow_scale3d = 0.05;  // Gaussians have 0.05 to 0.2
    options.prune_opa = 0.45;     // Gaussians have 0.3 to 0.9
    options.grow_grad2d = 1.65e-3;
    c.apply(options);
    return {model, Adam<B>({}, metric), DensityControl<typename B::Space>(options, kExtent, kSeed),
            LengthUnitViews(views_, kNear), kExtent};
  }
  // Makes a step on the host and returns its gradient.
  std::vector<float> StepHost() {
    const int attributes = splat::NumAttributes(host_->sh_degree());
    std::vector<float> gradient = random_.NormalVector<float>(static_cast<std::size_t>(host_->layout().Size()));
    std::copy(gradient.begin(), gradient.end(), host_->gradient(attributes));
    host_->Step(attributes, 1);
    return gradient;
  }
  vesta::test::Random random_{8};
  Scene scene_ = test::RingOfCameras(3, 40, 30, false);
  std::vector<const View*> views_;
  std::optional<TrainedModel<CpuBackend<float>>> host_;
  std::optional<TrainedModel<CudaBackend<float>>> device_;
};

class CudaDensity : public vesta::test::OnDevice {};

TEST_F(CudaDensity, ModelAndMomentsBecomeThoseOfTheHost) {
  for (const Case& c : kCases) {
    for (const SecondMoment metric : {SecondMoment::kBlock, SecondMoment::kDiagonal}) {
      SCOPED_TRACE(c.name);
      Both both(c, metric);
      both.ExpectTheSame(0);
      both.Densify();
      if (c.after > 0) {
        EXPECT_EQ(both.gaussians(), c.after);
      }
      both.ExpectTheSame(0);
      both.Step();
      both.ExpectTheSame(1e-5);
      both.ResetOpacity();
      both.ExpectTheSame(1e-5);
    }
  }
}

TEST_F(CudaDensity, DegreesAreLoweredAsOnTheHost) {
  Both both({"", 300, [](DensityOptions&) {}, [](SplatModel& m) { m = test::RandomModel(m.count, 3, 5); }},
            SecondMoment::kBlock);
  both.SetDegrees(DegreesOf(300));
  both.ExpectTheSame(0);
  both.Step();
  both.ExpectTheSame(1e-5);
  both.Densify();
  both.Step();
  both.ExpectTheSame(1e-5);
}

TEST_F(CudaDensity, WhatWasObservedIsForgotten) {
  // Fewer Gaussians, so the old arrays are large enough and could contain stale values.
  Both both({"", 300, [](DensityOptions& o) { o.prune_opa = 0.7, o.grow_grad2d = 1.75e-3; }, [](SplatModel&) {}},
            SecondMoment::kDiagonal);
  both.Densify();
  const Index after = both.gaussians();
  ASSERT_LT(after, 300);
  both.Densify();
  EXPECT_LE(both.gaussians(), after);
  both.ExpectTheSame(0);
}

TEST_F(CudaDensity, ObservesWhatTheHostObserves) {
  test::DensityScene host(60);
  DensityControl<Host> host_control({}, kExtent, kSeed);
  host_control.ResetStatistics(60);
  std::vector<float> grad2d(60);
  for (std::size_t i = 0; i < grad2d.size(); ++i) grad2d[i] = 1e-4f * static_cast<float>(1 + i);
  host.Observe(host_control, grad2d);
  // Observed twice from the splats on the GPU, with these gradients.
  const DeviceBuffer<float> x = vesta::test::ToDevice(host.model.data);
  const splat::Model<float> model{x.data(), 60, host.model.sh_degree, host.model.sh_degree};
  splat::DeviceViewWorkspace workspace;
  splat::DeviceSplatView view;
  view.Build(model, ToPosedCamera(host.scene.views[0], 0.01), std::array<double, 3>{}.data(), workspace);
  ASSERT_EQ(view.num_splats(), host.view.num_splats());
  workspace.splat_sums = vesta::test::ToDevice(host.cotangents);
  DensityControl<Device> control({}, kExtent, kSeed);
  control.ResetStatistics(60);
  for (int k = 0; k < 2; ++k)
    control.Observe(density::Grad2dOf(view, workspace.splat_sums.data(), test::DensityScene::kLossScale));
  const std::vector<float> found = vesta::test::ToHost(control.grad2d());
  for (std::size_t i = 0; i < found.size(); ++i) EXPECT_NEAR(found[i] / 2, host_control.grad2d()[i], 1e-3 * grad2d[i]);
  EXPECT_EQ(vesta::test::ToHost(control.seen()), std::vector<int>(60, 2));
}

}  // namespace
}  // namespace vesta::gs
