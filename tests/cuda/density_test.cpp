// Density control on the GPU against that of the host.
#include "problems/gaussian_splatting/density/density.h"

#include "problems/gaussian_splatting/adam/block_adam_formula.h"
#include "problems/gaussian_splatting/evaluate/metrics.h"
#include "problems/gaussian_splatting/model/length_units.h"
#include "problems/gaussian_splatting/train/device_model.h"
#include "tests/cuda/on_device.h"
#include "tests/problems/gaussian_splatting/density/density_scene.h"
#include "tests/support/random.h"

namespace vesta::gs {
namespace {

constexpr double kExtent = 2, kNear = 0.02;
constexpr std::uint64_t kSeed = 5;
constexpr int kSteps = 7, kIteration = 40;

struct Case {
  const char* name;
  Index gaussians;
  void (*apply)(DensityOptions&);
  void (*change)(SplatModel&);
  Index after = 0;  // so many are there then; 0: some
};
const Case kCases[] = {
    {"clones_splits_and_prunes", 300, [](DensityOptions&) {}, [](SplatModel&) {}},
    // Many pulls are alike, and the cap comes between them.
    {"cap", 300, [](DensityOptions& o) { o.max_gaussians = 250; }, [](SplatModel&) {}, 250},
    {"no_room", 300, [](DensityOptions& o) { o.max_gaussians = 10; }, [](SplatModel&) {}},
    {"all_split", 3, [](DensityOptions& o) { o.split_above = 1e-6, o.gradient_threshold = 0, o.prune_opacity = 0; },
     [](SplatModel&) {}, 6},
    {"huge_ones", 300, [](DensityOptions& o) { o.prune_size = 0.06; }, [](SplatModel&) {}},
    {"nothing_to_do", 40, [](DensityOptions& o) { o.gradient_threshold = 100, o.prune_opacity = 0; },
     [](SplatModel&) {}, 40},
    {"all_transparent", 40, [](DensityOptions&) {},
     [](SplatModel& m) { std::fill_n(m.attribute(splat::kOpacity), m.count, -9.0f); }},
    // A logit without an exponential in float.
    {"opaque_ones", 40, [](DensityOptions& o) { o.gradient_threshold = 0, o.split_above = 1; },
     [](SplatModel& m) { std::fill_n(m.attribute(splat::kOpacity), m.count, 200.0f); }},
};

// A model in training on the host, and the same on the GPU.
class Both {
 public:
  Both(const Case& c, AdamMetric metric)
      : host_(test::RandomModel(c.gaussians, 1, 5)),
        host_adam_({}, metric),
        host_density_(Options(c), kExtent, kSeed, c.gaussians),
        density_(Options(c), kExtent, kSeed) {
    for (const View& view : scene_.views) views_.push_back(&view);
    for (int step = 0; step < kSteps; ++step) {
      std::vector<float> gradient = random_.NormalVector<float>(host_.data.size());
      host_adam_.Step(host_, gradient.data(), host_.num_attributes(), 1);
    }
    c.change(host_);
    device_ = host_;
    device_adam_ = host_adam_;
    on_device_.emplace(device_, device_adam_, kSteps, density_, UnitViews(views_, kNear), kExtent);
    // Of few values, so that many are alike; of some Gaussians none.
    for (Index i = 0; i < c.gaussians; ++i) {
      const auto at = static_cast<std::size_t>(i);
      const Index seen = (i + 1) % 4, strength = 15 + (7 * i + 3) % 31 / 8;
      host_density_.seen()[at] = static_cast<int>(seen);
      host_density_.pull()[at] = 1e-4f * static_cast<float>(seen * strength);
    }
    density_.pull() = vesta::test::ToDevice(host_density_.pull());
    density_.seen() = vesta::test::ToDevice(host_density_.seen());
  }

  void Densify() {
    const Index before = host_.count;
    Index called_with = -1;
    host_density_.Densify(host_, host_adam_, kIteration);
    on_device_->Densify(kIteration, [&] { called_with = device_.count; });
    EXPECT_EQ(called_with, host_.count > before ? before : -1);
  }
  void ResetOpacity() {
    DensityControl::ResetOpacity(host_, host_adam_);
    on_device_->ResetOpacity();
  }
  // One step on both by the same gradient, with the rates and the units of a new model.
  void Step() {
    host_adam_.SetUnits(LengthUnits(host_, views_, kNear, kExtent));
    std::vector<float> gradient = random_.NormalVector<float>(host_.data.size());
    DeviceBuffer<float> on_device = vesta::test::ToDevice(gradient);
    ASSERT_EQ(vesta::test::ToHost(on_device).size(), gradient.size());
    device::Copy(on_device_->gradient(), on_device.data(), gradient.size() * sizeof(float));
    host_adam_.Step(host_, gradient.data(), host_.num_attributes(), 1);
    on_device_->Step(host_.num_attributes(), 1);
  }

  Index gaussians() const { return host_.count; }
  void ExpectTheSame(double tolerance) {
    ASSERT_EQ(device_.count, host_.count);
    on_device_->DownloadParameters();
    ASSERT_EQ(device_.data.size(), host_.data.size());
    // Copied values are the same to the bit; values from exp, log and cos may differ by their rounding.
    if (tolerance == 0) {
      for (int a = splat::kQuaternion; a < host_.num_attributes(); ++a) {
        if (a == splat::kOpacity) continue;
        for (Index i = 0; i < host_.count; ++i) ASSERT_EQ(device_.attribute(a)[i], host_.attribute(a)[i]) << a << i;
      }
    }
    EXPECT_LT(vesta::test::RelativeError(device_.data, host_.data), std::max(tolerance, 1e-6));
    const Adam adam = on_device_->DownloadAdam();
    const auto expect_same = [&](const std::vector<float>& found, const std::vector<float>& expected) {
      ASSERT_EQ(found.size(), expected.size());
      if (tolerance == 0) {
        EXPECT_EQ(found, expected);
      } else if (!expected.empty()) {
        EXPECT_LT(vesta::test::RelativeError(found, expected), tolerance);
      }
    };
    expect_same(adam.moments().first, host_adam_.moments().first);
    expect_same(adam.moments().second, host_adam_.moments().second);
    expect_same(adam.moments().bases.Flat(), host_adam_.moments().bases.Flat());
  }

 private:
  static DensityOptions Options(const Case& c) {
    DensityOptions options;
    options.split_above = 0.05;    // of Gaussians of 0.05 to 0.2
    options.prune_opacity = 0.45;  // of 0.3 to 0.9
    options.gradient_threshold = 1.65e-3;
    c.apply(options);
    return options;
  }

  vesta::test::Random random_{8};
  Scene scene_ = test::RingOfCameras(3, 40, 30, false);
  std::vector<const View*> views_;
  SplatModel host_, device_;
  Adam host_adam_, device_adam_{LearningRates()};
  DensityControl host_density_;
  DeviceDensityControl density_;
  std::optional<DeviceModel> on_device_;
};

class CudaDensity : public vesta::test::OnDevice {};

TEST_F(CudaDensity, ModelAndMomentsBecomeThoseOfTheHost) {
  for (const Case& c : kCases) {
    for (const AdamMetric metric : {AdamMetric::kBlock, AdamMetric::kDiagonal}) {
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

// A new model has been observed nowhere.
TEST_F(CudaDensity, WhatWasObservedIsForgotten) {
  // Fewer than before, so that their numbers fit where the old ones are.
  Both both(
      {"", 300, [](DensityOptions& o) { o.prune_opacity = 0.7, o.gradient_threshold = 1.75e-3; }, [](SplatModel&) {}},
      AdamMetric::kDiagonal);
  both.Densify();
  const Index after = both.gaussians();
  ASSERT_LT(after, 300);
  both.Densify();
  EXPECT_LE(both.gaussians(), after);
  both.ExpectTheSame(0);
}

TEST_F(CudaDensity, ObservesWhatTheHostObserves) {
  test::DensityScene host(60);
  DensityControl host_control({}, kExtent, kSeed, 60);
  std::vector<float> pull(60);
  for (std::size_t i = 0; i < pull.size(); ++i) pull[i] = 1e-4f * static_cast<float>(1 + i);
  host.Observe(host_control, pull);
  // The same twice from the GPU's own splats: pulls as given there.
  const DeviceBuffer<float> x = vesta::test::ToDevice(host.model.data);
  const splat::Model<float> model{x.data(), 60, host.model.sh_degree, host.model.sh_degree};
  splat::DeviceViewWorkspace workspace;
  splat::DeviceView view;
  view.Build(model, ToPinhole(host.scene.views[0], 0.01), std::array<double, 3>{}.data(), workspace);
  ASSERT_EQ(view.num_splats(), host.view.num_splats());
  workspace.splat_sums = vesta::test::ToDevice(host.cotangents);
  DeviceDensityControl control({}, kExtent, kSeed);
  control.Forget(60);
  for (int k = 0; k < 2; ++k) control.Observe(view, workspace, test::DensityScene::kLossScale);
  const std::vector<float> found = vesta::test::ToHost(control.pull());
  for (std::size_t i = 0; i < found.size(); ++i) EXPECT_NEAR(found[i] / 2, host_control.pull()[i], 1e-3 * pull[i]);
  EXPECT_EQ(vesta::test::ToHost(control.seen()), std::vector<int>(60, 2));
}

}  // namespace
}  // namespace vesta::gs
