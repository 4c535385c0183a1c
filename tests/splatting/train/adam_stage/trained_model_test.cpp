// SPDX-License-Identifier: Apache-2.0
// Lowering SH degrees during Adam.
#include "splatting/train/adam_stage/trained_model.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "tests/splatting/density/density_scene.h"
#include "tests/support/random.h"

namespace vesta::gs {
namespace {

using Cpu = CpuBackend<float>;
constexpr Index kCount = 300;  // more than one chunk of Adam's blocks
constexpr int kAttributes = splat::kMaxAttributes;

std::vector<std::uint8_t> RandomDegrees(Index count, std::uint64_t seed) {
  vesta::test::Random random(seed);
  std::vector<std::uint8_t> degrees;
  degrees.reserve(static_cast<std::size_t>(count));
  for (Index i = 0; i < count; ++i) degrees.push_back(static_cast<std::uint8_t>(random.Uniform(0, 3.999)));
  return degrees;
}

class TrainedModels : public testing::Test {
 protected:
  TrainedModel<Cpu> Start(const SplatModel& model) const {
    std::vector<const View*> views;
    for (const View& view : scene_.views) views.push_back(&view);
    DensityOptions options;
    options.grow_scale3d = 0.1, options.prune_opa = 0.45, options.grow_grad2d = 1e-3;
    return {model, Adam<Cpu>({}, SecondMoment::kBlock), DensityControl<Host>(options, 2, 5),
            LengthUnitViews(views, 0.02), 2};
  }
  // A step with gradients of the original model; originals_of[i] is the original index of Gaussian i.
  void Step(TrainedModel<Cpu>& trained, const std::vector<float>& gradient, Index originals,
            const std::vector<std::uint32_t>& originals_of) const {
    float* g = trained.gradient(kAttributes);
    const splat::ModelLayout& layout = trained.layout();
    for (int a = 0; a < splat::NumAttributes(layout.sh_degree); ++a) {
      for (Index i = 0; i < layout.Rows(a); ++i) {
        g[layout.Offset(a) + i] = gradient[static_cast<std::size_t>(a * originals + originals_of[i])];
      }
    }
    trained.Step(splat::NumAttributes(layout.sh_degree), 1);
    trained.Average();
  }
  std::vector<float> Gradient(std::uint64_t seed) const {
    return vesta::test::Random(seed).NormalVector<float>(static_cast<std::size_t>(kAttributes * kCount));
  }

  Scene scene_ = test::RingOfCameras(3, 40, 30, false);
};

SplatModel Of(const splat::ModelLayout& layout, const HostBuffer<float>& values) {
  SplatModel model;
  model.Resize(layout);
  EXPECT_EQ(values.size(), layout.Size());
  std::copy(values.begin(), values.end(), model.data.begin());
  return model;
}

// Removing SH bands early does not affect other parameters: they have the bits of a training that removes them at the
// end.
TEST_F(TrainedModels, WhatIsLeftTrainsOnAsBefore) {
  const SplatModel model = test::RandomModel(kCount, 3, 5);
  const std::vector<std::uint8_t> degrees = RandomDegrees(kCount, 6);
  const DegreeOrder order = OrderByDegree(model, degrees);
  std::vector<std::uint32_t> same(kCount);
  for (std::uint32_t i = 0; i < kCount; ++i) same[i] = i;

  TrainedModel<Cpu> late = Start(model), early = Start(model);
  for (int step = 0; step < 3; ++step) {
    Step(late, Gradient(20 + step), kCount, same);
    Step(early, Gradient(20 + step), kCount, same);
  }
  early.density().grad2d()[7] = 3, late.density().grad2d()[7] = 3;
  early.density().seen()[7] = 2, late.density().seen()[7] = 2;
  early.SetDegrees(degrees);
  EXPECT_EQ(early.layout(), order.layout);
  EXPECT_TRUE(early.IsWhole());
  for (int step = 0; step < 4; ++step) {
    Step(late, Gradient(40 + step), kCount, same);
    Step(early, Gradient(40 + step), kCount, order.source);
  }
  const auto lowered = [&](const HostBuffer<float>& values) {
    return TakeGaussians(Of(late.layout(), values), order).data;
  };
  const auto values = [](const HostBuffer<float>& buffer) { return std::vector<float>(buffer.begin(), buffer.end()); };
  EXPECT_EQ(values(early.parameters()), lowered(late.parameters()));
  EXPECT_EQ(values(early.adam().first()), lowered(late.adam().first()));
  EXPECT_EQ(values(early.adam().second()), lowered(late.adam().second()));
  SplatModel mean, mean_of_late;
  early.DownloadResult(mean), late.DownloadResult(mean_of_late);
  EXPECT_EQ(mean.data, TakeGaussians(mean_of_late, order).data);
  for (Index k = 0; k < kCount; ++k) {
    const Index i = order.source[static_cast<std::size_t>(k)];
    ASSERT_EQ(early.adam().units()[k], late.adam().units()[i]);
    ASSERT_EQ(early.density().grad2d()[k], late.density().grad2d()[i]);
    ASSERT_EQ(early.density().seen()[k], late.density().seen()[i]);
  }
}

// Adam updates its bases in chunks of Gaussians. In another chunk, a moved Gaussian is updated at another step. Only
// the state right after the move is therefore identical.
TEST_F(TrainedModels, BasesGoWithTheirGaussians) {
  TrainedModel<Cpu> trained = Start(test::RandomModel(kCount, 3, 5));
  std::vector<std::uint32_t> same(kCount);
  for (std::uint32_t i = 0; i < kCount; ++i) same[i] = i;
  for (int step = 0; step < 30; ++step) Step(trained, Gradient(20 + step), kCount, same);
  const BlockBases<Host> before = trained.adam().bases();
  const std::vector<std::uint8_t> degrees = RandomDegrees(kCount, 6);
  const DegreeOrder order = OrderByDegree(trained.layout(), degrees);
  trained.SetDegrees(degrees);
  for (Index k = 0; k < kCount; ++k) {
    for (int number = 0; number < kBlockNumbers; ++number) {
      ASSERT_EQ(trained.adam().bases().At(number, k), before.At(number, order.source[static_cast<std::size_t>(k)]));
    }
  }
}

TEST_F(TrainedModels, DegreesAreHandedDown) {
  const SplatModel model = test::WithDegrees(test::RandomModel(kCount, 3, 5), RandomDegrees(kCount, 7));
  // Clones and splits keep the constant colour coefficient, which identifies the original.
  std::map<float, Index> known;
  for (Index i = 0; i < kCount; ++i) known[model.attribute(splat::kSh)[i]] = i;
  TrainedModel<Cpu> trained = Start(model);
  for (Index i = 0; i < kCount; ++i) trained.density().grad2d()[i] = i % 3 ? 1.0f : 0, trained.density().seen()[i] = 1;
  trained.Densify(1, [] {});
  SplatModel after;
  trained.DownloadParameters(after);
  EXPECT_TRUE(trained.IsWhole());
  EXPECT_NE(after.count, kCount);
  for (Index i = 0; i < after.count; ++i) {
    const Index from = known.at(after.attribute(splat::kSh)[i]);
    EXPECT_EQ(after.DegreeOf(i), model.DegreeOf(from));
    for (int a = splat::kSh; a < splat::NumAttributes(after.DegreeOf(i)); ++a) {
      EXPECT_EQ(after.attribute(a)[i], model.attribute(a)[from]);
    }
  }
  // Without Gaussians of the highest degree, the model's degree falls.
  std::vector<Index> low;
  for (Index i = trained.layout().WithBand(2); i < trained.count(); ++i) low.push_back(i);
  trained.Keep(low);
  EXPECT_EQ(trained.sh_degree(), 1);
  EXPECT_TRUE(trained.IsWhole());
}

}  // namespace
}  // namespace vesta::gs
