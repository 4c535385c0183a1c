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
constexpr int kSteps = 7;
// Pulls are 0 to 18; the threshold is 33 * 0.5 = 16.5.
constexpr double kGrowPull = 33, kPrice = 0.5;

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
    {"splits_and_prunes", 300, [](DensityOptions&) {}, [](SplatModel&) {}},
    // The limit falls between equal pulls.
    {"cap", 300, [](DensityOptions& o) { o.max_gaussians = 250; }, [](SplatModel&) {}, 250},
    {"no_room", 300, [](DensityOptions& o) { o.max_gaussians = 10; }, [](SplatModel&) {}},
    {"all_split", 3, [](DensityOptions& o) { o.grow_pull = 0, o.prune_opa = 0; }, [](SplatModel&) {}, 6},
    {"huge_ones", 300, [](DensityOptions& o) { o.prune_scale3d = 0.06; }, [](SplatModel&) {}},
    {"nothing_to_do", 40, [](DensityOptions& o) { o.grow_pull = 100, o.prune_opa = 0; }, [](SplatModel&) {}, 40},
    {"all_transparent", 40, [](DensityOptions&) {},
     [](SplatModel& m) { std::fill_n(m.attribute(splat::kOpacity), m.count, -9.0f); }},
    {"different_degrees", 300, [](DensityOptions&) {}, [](SplatModel& m) { m = OfDifferentDegrees(m.count); }},
    // exp of this logit overflows in float.
    {"opaque_ones", 40, [](DensityOptions& o) { o.grow_pull = 0; },
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
    std::vector<float> pulls;
    for (Index i = 0; i < c.gaussians; ++i) {
      const Index level = 15 + (7 * i + 3) % 31 / 8;
      pulls.push_back(i % 4 == 3 ? 0.0f : static_cast<float>(level));
    }
    host_->density().pull().CopyFrom(vesta::test::ViewOf(pulls));
    device_->density().pull().CopyFrom(vesta::test::ViewOf(pulls));
  }

  void Densify() {
    const Index before = host_->count();
    for (const bool on_device : {false, true}) {
      Index called_with = -1;
      if (on_device) {
        device_->Densify(kPrice, [&] { called_with = device_->count(); });
      } else {
        host_->Densify(kPrice, [&] { called_with = host_->count(); });
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
    ExpectTheSamePullsAndUnits();
  }
  // Keeps two of three Gaussians.
  void Keep() {
    std::vector<Index> kept;
    for (Index i = 0; i < gaussians(); ++i) {
      if (i % 3 != 1) kept.push_back(i);
    }
    host_->Keep(kept);
    device_->Keep(kept);
    ExpectTheSamePullsAndUnits();
  }
  void ShrinkLongerAxes() {
    std::vector<float> by;
    for (Index i = 0; i < gaussians(); ++i) by.push_back(0.1f * static_cast<float>(i % 5));
    host_->ShrinkLongerAxes(by);
    device_->ShrinkLongerAxes(by);
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
    options.prune_opa = 0.45;  // Gaussians have 0.3 to 0.9
    options.grow_pull = kGrowPull;
    c.apply(options);
    return {model, Adam<B>({}, metric), DensityControl<typename B::Space>(options, kExtent),
            LengthUnitViews(views_, kNear), kExtent};
  }
  void ExpectTheSamePullsAndUnits() {
    EXPECT_EQ(vesta::test::ToHost(device_->density().pull()),
              std::vector<float>(host_->density().pull().begin(), host_->density().pull().end()));
    EXPECT_LT(vesta::test::RelativeError(vesta::test::ToHost(device_->adam().units()), host_->adam().units()), 1e-5);
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

TEST_F(CudaDensity, GaussiansAreKeptAndShrunkAsOnTheHost) {
  Both both({"", 300, [](DensityOptions&) {}, [](SplatModel& m) { m = OfDifferentDegrees(m.count); }},
            SecondMoment::kBlock);
  both.Keep();
  EXPECT_EQ(both.gaussians(), 200);
  both.ExpectTheSame(0);
  both.ShrinkLongerAxes();
  both.ExpectTheSame(0);
  both.Densify();
  both.Step();
  both.ExpectTheSame(1e-5);
}

TEST_F(CudaDensity, WhatWasObservedIsForgotten) {
  // Fewer Gaussians, so the old arrays are large enough and could contain stale values.
  Both both({"", 300, [](DensityOptions& o) { o.prune_opa = 0.7, o.grow_pull = 35; }, [](SplatModel&) {}},
            SecondMoment::kDiagonal);
  both.Densify();
  const Index after = both.gaussians();
  ASSERT_LT(after, 300);
  both.Densify();
  EXPECT_LE(both.gaussians(), after);
  both.ExpectTheSame(0);
}

TEST_F(CudaDensity, ObservesWhatTheHostObserves) {
  constexpr Index kCount = 60;
  test::DensityScene host(kCount);
  const DeviceBuffer<float> x = vesta::test::ToDevice(host.model.data);
  const splat::Model<float> model{x.data(), kCount, host.model.sh_degree, host.model.sh_degree};
  DensityControl<Host> host_control({}, kExtent);
  DensityControl<Device> control({}, kExtent);
  host_control.ResetStatistics(kCount), control.ResetStatistics(kCount);
  std::vector<float> pulls;
  for (Index i = 0; i < kCount; ++i) pulls.push_back(static_cast<float>(1 + i));
  host.Observe(host_control, pulls);
  const splat::PosedCamera camera = ToPosedCamera(host.scene.views[0], 0.01);
  splat::DeviceViewWorkspace workspace;
  splat::DeviceSplatView view;
  view.Build(model, camera, std::array<double, 3>{}.data(), workspace);
  ASSERT_EQ(view.num_splats(), host.view.num_splats());
  // Observed twice from the splats on the GPU, with these pulls.
  workspace.splat_sums = vesta::test::ToDevice(host.cotangents);
  const auto observe = [&] {
    control.Observe({view.rank_of().data(), view.splats().data(), workspace.splat_sums.data(), host.kScale});
  };
  observe(), observe();
  EXPECT_EQ(control.views(), 2);
  std::vector<float> found = vesta::test::ToHost(control.pull());
  for (Index i = 0; i < kCount; ++i) {
    const auto k = static_cast<std::size_t>(i);
    EXPECT_NEAR(found[k] / 2, host_control.pull()[i], 1e-3 * pulls[k]);
  }
  // The pulls of the adjoint pass.
  DeviceBuffer<float> image(3 * view.num_pixels()), gradient(static_cast<Index>(host.model.data.size()));
  std::vector<float> host_image(static_cast<std::size_t>(image.size()));
  view.Render(image.data());
  host.view.Render(host_image.data());
  const std::vector<float> u = vesta::test::Random(6).NormalVector<float>(host_image.size());
  const DeviceBuffer<float> device_u = vesta::test::ToDevice(u);
  view.AddJT(model, image.data(), device_u.data(), gradient.data(), workspace);
  control.ResetStatistics(kCount), host_control.ResetStatistics(kCount);
  observe();
  const splat::SplatTangent<float>* sums = host.view.ApplyRasterJT(host_image.data(), u.data(), host.workspace);
  host_control.Observe({host.view.rank_of().data(), host.view.splats().data(), sums, host.kScale});
  found = vesta::test::ToHost(control.pull());
  double largest = 0;
  for (Index i = 0; i < kCount; ++i) {
    largest = std::max<double>(largest, host_control.pull()[i]);
    EXPECT_NEAR(found[static_cast<std::size_t>(i)], host_control.pull()[i], 1e-3 * host_control.pull()[i] + 1e-3) << i;
  }
  EXPECT_GT(largest, 1);
}

}  // namespace
}  // namespace vesta::gs
