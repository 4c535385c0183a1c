// SPDX-License-Identifier: Apache-2.0
// Changes of the Gaussians during Adam.
#include "splatting/train/adam_stage/trained_model.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>

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
  std::vector<const View*> Views() const {
    std::vector<const View*> views;
    for (const View& view : scene_.views) views.push_back(&view);
    return views;
  }
  TrainedModel<Cpu> Start(const SplatModel& model) const {
    DensityOptions options;
    options.prune_opa = 0.45, options.grow_pull = 2;
    return {model, Adam<Cpu>({}, SecondMoment::kBlock), DensityControl<Host>(options, 2),
            LengthUnitViews(Views(), 0.02), 2};
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
  for (Index i = 0; i < kCount; ++i) early.density().pull()[i] = late.density().pull()[i] = static_cast<float>(i);
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
    ASSERT_EQ(early.density().pull()[k], late.density().pull()[i]);
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
  // Halves keep the constant colour coefficient, which identifies the original.
  std::map<float, Index> known;
  for (Index i = 0; i < kCount; ++i) known[model.attribute(splat::kSh)[i]] = i;
  TrainedModel<Cpu> trained = Start(model);
  for (Index i = 0; i < kCount; ++i) trained.density().pull()[i] = i % 3 ? 1.0f : 0;
  trained.Densify(0.4, [] {});
  SplatModel after;
  trained.DownloadParameters(after);
  EXPECT_TRUE(trained.IsWhole());
  EXPECT_GT(after.count, kCount);
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

// Kept Gaussians keep all that is stored for them, except length units.
TEST_F(TrainedModels, KeptGaussiansKeepTheirState) {
  const SplatModel model = test::WithDegrees(test::RandomModel(kCount, 3, 5), RandomDegrees(kCount, 7));
  TrainedModel<Cpu> all = Start(model), some = Start(model);
  std::vector<std::uint32_t> same(kCount);
  for (std::uint32_t i = 0; i < kCount; ++i) same[i] = i;
  for (int step = 0; step < 3; ++step) {
    Step(all, Gradient(20 + step), kCount, same);
    Step(some, Gradient(20 + step), kCount, same);
  }
  for (Index i = 0; i < kCount; ++i) some.density().pull()[i] = static_cast<float>(i);
  some.density().CountViews(5);
  std::vector<Index> kept;
  for (Index i = 0; i < kCount; ++i) {
    if (i % 5 != 1) kept.push_back(i);
  }
  some.Keep(kept);
  EXPECT_TRUE(some.IsWhole());
  EXPECT_EQ(some.count(), static_cast<Index>(kept.size()));
  EXPECT_EQ(some.density().views(), 5);
  SplatModel whole, average, left;
  all.DownloadResult(average), some.DownloadResult(left);
  EXPECT_EQ(left.data, InOrder(average, kept).data);
  all.DownloadParameters(whole), some.DownloadParameters(left);
  ASSERT_NE(whole.data, average.data);
  EXPECT_EQ(left.data, InOrder(whole, kept).data);
  EXPECT_EQ(Of(left, some.adam().first()).data, InOrder(Of(whole, all.adam().first()), kept).data);
  EXPECT_EQ(Of(left, some.adam().second()).data, InOrder(Of(whole, all.adam().second()), kept).data);
  // The statistics too. Length units are measured anew, as they depend on the means.
  const std::vector<float> units = LengthUnits(left, Views(), 0.02, 2);
  std::set<float> different_units;
  for (Index k = 0; k < some.count(); ++k) {
    ASSERT_EQ(some.density().pull()[k], static_cast<float>(kept[static_cast<std::size_t>(k)]));
    ASSERT_EQ(some.adam().units()[k], units[static_cast<std::size_t>(k)]);
    different_units.insert(some.adam().units()[k]);
  }
  EXPECT_GT(different_units.size(), 10U);
}

TEST_F(TrainedModels, TwoLongerAxesShrink) {
  const SplatModel model = test::WithDegrees(test::RandomModel(kCount, 3, 5), RandomDegrees(kCount, 7));
  TrainedModel<Cpu> trained = Start(model);
  std::vector<std::uint32_t> same(kCount);
  for (std::uint32_t i = 0; i < kCount; ++i) same[i] = i;
  for (int step = 0; step < 2; ++step) Step(trained, Gradient(20 + step), kCount, same);
  SplatModel before, after, average, average_after;
  trained.DownloadParameters(before), trained.DownloadResult(average);
  ASSERT_NE(average.data, before.data);
  std::vector<float> by;
  for (Index i = 0; i < kCount; ++i) by.push_back(0.1f * static_cast<float>(i % 6));
  trained.ShrinkLongerAxes(by);
  trained.DownloadParameters(after), trained.DownloadResult(average_after);
  EXPECT_EQ(average_after.data, average.data) << "the average of earlier parameters remains";
  ASSERT_EQ(after.layout(), before.layout());
  std::vector<int> shortest_is(3);
  for (Index i = 0; i < kCount; ++i) {
    int shortest = 0;
    for (int k = 1; k < 3; ++k) {
      if (before.attribute(splat::kLogScale + k)[i] < before.attribute(splat::kLogScale + shortest)[i]) shortest = k;
    }
    ++shortest_is[static_cast<std::size_t>(shortest)];
    for (int k = 0; k < 3; ++k) {
      const float old = before.attribute(splat::kLogScale + k)[i];
      ASSERT_EQ(after.attribute(splat::kLogScale + k)[i], k == shortest ? old : old - by[static_cast<std::size_t>(i)]);
    }
  }
  for (const int count : shortest_is) EXPECT_GT(count, 10);
  // Nothing else changes.
  std::copy_n(before.attribute(splat::kLogScale), 3 * kCount, after.attribute(splat::kLogScale));
  EXPECT_EQ(after.data, before.data);
}

// Halves come in pairs; the moments of both are zero.
TEST_F(TrainedModels, DensifyResetsStatisticsUnitsAndMoments) {
  TrainedModel<Cpu> trained = Start(test::RandomModel(kCount, 3, 5));
  std::vector<std::uint32_t> same(kCount);
  for (std::uint32_t i = 0; i < kCount; ++i) same[i] = i;
  Step(trained, Gradient(20), kCount, same);
  trained.density().pull()[4] = 1, trained.density().CountViews(2);
  std::fill_n(trained.density().pull().data() + 250, 3, 1.0f);
  Index called = 0;
  // The threshold is twice the price.
  trained.Densify(0.6, [&] { ++called; });
  EXPECT_EQ(called, 0);
  EXPECT_EQ(trained.density().views(), 0);
  trained.density().CountViews(2);
  std::fill_n(trained.density().pull().data() + 100, 3, 1.0f);
  const Index before = trained.count();
  trained.Densify(0.4, [&] { called += trained.count(); });
  EXPECT_EQ(called, before) << "once, before Gaussians are added";
  EXPECT_EQ(trained.count(), before + 3);
  EXPECT_EQ(trained.density().views(), 0);
  EXPECT_EQ(trained.adam().units().size(), before + 3);
  for (Index i = 0; i < trained.count(); ++i) {
    EXPECT_EQ(trained.density().pull()[i], 0);
    EXPECT_EQ(trained.adam().first()[i] == 0, i >= 100 && i < 106) << i;
  }
}

}  // namespace
}  // namespace vesta::gs
