// SPDX-License-Identifier: Apache-2.0
#include "splatting/adam/adam.h"

#include <gtest/gtest.h>

#include <cmath>

#include "kernels/gaussian_splatting/formulas/layout.h"
#include "tests/problems/gaussian_splatting/ring_scene.h"
#include "tests/splatting/adam/model_adam.h"
#include "tests/support/random.h"

namespace vesta::gs {
namespace {

TEST(Adam, RatesFollowTheLayout) {
  const LearningRates rates;
  EXPECT_EQ(RateOf(rates, splat::kMean + 2), rates.position);
  EXPECT_EQ(RateOf(rates, splat::kLogScale), rates.log_scale);
  EXPECT_EQ(RateOf(rates, splat::kLogScale + 2), rates.log_scale);
  EXPECT_EQ(RateOf(rates, splat::kQuaternion + 3), rates.quaternion);
  EXPECT_EQ(RateOf(rates, splat::kOpacity), rates.opacity);
  EXPECT_EQ(RateOf(rates, splat::kSh + 2), rates.sh_dc);
  EXPECT_EQ(RateOf(rates, splat::kSh + 3), rates.sh_rest);
}

// The first step has the size of the learning rate, for any gradient.
TEST(Adam, FirstStepIsTheRate) {
  SplatModel model;
  model.Resize(1, 3);
  std::vector<float> gradient(model.data.size());
  const float values[] = {1e-6f, -1e5f, 0.0f};
  for (std::size_t k = 0; k < gradient.size(); ++k) gradient[k] = values[k % 3];
  test::ModelAdam adam{LearningRates()};
  adam.Step(model, gradient.data(), model.num_attributes(), 2.0);
  for (int a = 0; a < model.num_attributes(); ++a) {
    const double step = 2 * RateOf({}, a);
    EXPECT_NEAR(model.attribute(a)[0], -step, 1e-6 * step);
    EXPECT_NEAR(model.attribute(a)[1], step, 1e-6 * step);
    EXPECT_EQ(model.attribute(a)[2], 0);
  }
}

// Four views a step: twice the rate.
TEST(Adam, ByMoreViewsStepsAreLonger) {
  SplatModel model;
  model.Resize(1, 1);
  std::vector<float> gradient(model.data.size(), 3e-4f);
  test::ModelAdam adam(LearningRates(), SecondMoment::kDiagonal, 4);
  adam.Step(model, gradient.data(), model.num_attributes(), 1.0);
  for (int a = 0; a < model.num_attributes(); ++a) {
    const double step = 2 * RateOf({}, a);
    EXPECT_NEAR(model.attribute(a)[0], -step, 1e-6 * step);
  }
}

// A step of four views decays second moments like four steps of one; so does the bias correction.
TEST(Adam, SecondMomentsCountViews) {
  SplatModel model;
  model.Resize(0, 1);
  test::ModelAdam adam(LearningRates(), SecondMoment::kDiagonal, 4);
  const auto step = [&](float pull) {
    const float before = model.data[0];
    std::vector<float> gradient(model.data.size(), pull);
    adam.Step(model, gradient.data(), model.num_attributes(), 1.0);
    return double{before - model.data[0]};
  };
  const double beta2 = std::pow(0.999, 4);
  step(3);
  EXPECT_NEAR(adam.adam().second()[0], 9 * (1 - beta2), 1e-6);
  const double second = step(1), root = std::sqrt((9 * beta2 + 1) * (1 - beta2) / (1 - beta2 * beta2));
  const double first = (0.7 * 0.3 * 3 + 0.3) / (1 - 0.7 * 0.7);
  EXPECT_NEAR(second, 2 * LearningRates().position * first / root, 1e-4 * second);
}

// Algorithm 1 of Kingma and Ba (Adam) in double, for one parameter. Zero gradients change nothing.
class PlainAdam {
 public:
  double Step(double gradient, double rate) {
    ++steps_;
    if (gradient == 0) return 0;
    first_ = kBeta1 * first_ + (1 - kBeta1) * gradient;
    second_ = 0.999 * second_ + 0.001 * gradient * gradient;
    return -rate * (first_ / (1 - std::pow(kBeta1, steps_))) / std::sqrt(second_ / (1 - std::pow(0.999, steps_)));
  }

 private:
  static constexpr double kBeta1 = 0.7;
  double first_ = 0, second_ = 0;
  int steps_ = 0;
};

TEST(Adam, FollowsThePlainAlgorithm) {
  SplatModel model;
  model.Resize(0, 5003);  // more than one task, no multiple of the vector width
  vesta::test::Random random(1);
  std::vector<PlainAdam> plain(model.data.size());
  std::vector<double> expected(model.data.size());
  test::ModelAdam adam{LearningRates()};
  std::vector<float> units(5003);
  for (std::size_t i = 0; i < units.size(); ++i) units[i] = 0.5f + 1e-3f * static_cast<float>(i);
  adam.SetUnits(units);
  for (int step = 0; step < 50; ++step) {
    // Gradients have a mean, so that steps do not cancel.
    std::vector<float> gradient = random.NormalVector<float>(model.data.size());
    for (float& value : gradient) value = 1e3f * (value + 1.5f);
    // Unseen Gaussians: whole vectors, and single ones.
    for (std::size_t k = 0; k < gradient.size(); ++k) {
      const std::size_t i = k % 5003;
      if ((i / 100 + static_cast<std::size_t>(step)) % 3 == 0 || (i * 7 + static_cast<std::size_t>(step)) % 11 == 0) {
        gradient[k] = 0;
      }
    }
    const double factor = std::pow(0.98, step);
    for (std::size_t k = 0; k < plain.size(); ++k) {
      const auto attribute = static_cast<int>(k / 5003);
      const double unit = attribute < splat::kLogScale ? units[k % 5003] : 1;
      const double rate = factor * unit * RateOf({}, attribute);
      expected[k] += plain[k].Step(gradient[k], rate);
    }
    adam.Step(model, gradient.data(), model.num_attributes(), factor);
    for (const float value : gradient) ASSERT_EQ(value, 0) << "zeroed for the next sum";
  }
  for (std::size_t k = 0; k < plain.size(); ++k) {
    ASSERT_NEAR(model.data[k], expected[k], 1e-5 * std::abs(expected[k])) << k;
  }
}

// Attributes beyond the active ones do not change.
TEST(Adam, MovesActiveAttributesOnly) {
  SplatModel model = test::RandomModel(4, 2, 2);
  const SplatModel before = model;
  std::vector<float> gradient(model.data.size(), 1.0f);
  test::ModelAdam adam{LearningRates()};
  adam.Step(model, gradient.data(), splat::NumAttributes(1), 1);
  for (int a = 0; a < model.num_attributes(); ++a) {
    for (Index i = 0; i < model.count; ++i) {
      EXPECT_EQ(model.attribute(a)[i] != before.attribute(a)[i], a < splat::NumAttributes(1)) << a;
    }
  }
}

// In a step with this gradient everywhere.
float MoveOfOpacity(test::ModelAdam& adam, SplatModel& model, float gradient, Index i) {
  const float before = model.attribute(splat::kOpacity)[i];
  std::vector<float> all(model.data.size(), gradient);
  adam.Step(model, all.data(), model.num_attributes(), 1);
  return model.attribute(splat::kOpacity)[i] - before;
}

TEST(Adam, RearrangeKeepsMomentsAndClearsThem) {
  SplatModel model;
  model.Resize(0, 2);
  test::ModelAdam adam{LearningRates()}, reference{LearningRates()};
  SplatModel same = model;
  // Gaussians 0 and 1 have opposite gradients.
  std::vector<float> gradient(model.data.size());
  for (std::size_t k = 0; k < gradient.size(); ++k) gradient[k] = k % 2 == 0 ? 1.0f : -1.0f;
  for (int step = 0; step < 5; ++step) {
    std::vector<float> copy = gradient, another = gradient;
    adam.Step(model, copy.data(), model.num_attributes(), 1);
    reference.Step(same, another.data(), same.num_attributes(), 1);
  }
  // Gaussian 1 is copied twice with its moments, Gaussian 0 without.
  adam.Rearrange({1, 0, 1}, {true, false, true});
  model = InOrder(std::move(model), {1, 0, 1});
  model.count = 3;
  EXPECT_EQ(model.attribute(splat::kOpacity)[0], same.attribute(splat::kOpacity)[1]);
  EXPECT_EQ(model.attribute(splat::kOpacity)[1], same.attribute(splat::kOpacity)[0]);
  const SplatModel before = model;
  std::vector<float> little(model.data.size(), 1e-6f), as_little = little;
  adam.Step(model, little.data(), model.num_attributes(), 1);
  reference.Step(same, as_little.data(), same.num_attributes(), 1);
  for (int a = 0; a < model.num_attributes(); ++a) {
    EXPECT_EQ(model.attribute(a)[0], same.attribute(a)[1]);
    EXPECT_NE(model.attribute(a)[1], same.attribute(a)[0]) << "the copy starts without moments";
    EXPECT_EQ(model.attribute(a)[2], same.attribute(a)[1]);
    EXPECT_NE(model.attribute(a)[0], before.attribute(a)[0]);
  }
}

TEST(Adam, ResetForgetsOneAttribute) {
  SplatModel model;
  model.Resize(0, 2);
  test::ModelAdam adam{LearningRates()};
  MoveOfOpacity(adam, model, 1.0f, 0);
  adam.Reset(splat::kOpacity);
  const SplatModel before = model;
  // Only the second gradient acts on the opacity. Other attributes still have momentum of the first.
  const double opacity = MoveOfOpacity(adam, model, -1.0f, 0) / LearningRates().opacity;
  const double mean = (model.attribute(splat::kMean)[0] - before.attribute(splat::kMean)[0]) / LearningRates().position;
  EXPECT_GT(mean, 0);
  EXPECT_GT(opacity, 3 * mean);
}

TEST(Adam, RearrangeAndResetBeforeTheFirstStepDoNothing) {
  SplatModel model;
  model.Resize(0, 2);
  test::ModelAdam adam{LearningRates()};
  adam.Rearrange({0, 1}, {true, false});
  adam.Reset(splat::kOpacity);
  EXPECT_NEAR(MoveOfOpacity(adam, model, 1.0f, 1), -LearningRates().opacity, 1e-7);
}

TEST(Adam, UnseenParametersStayForever) {
  SplatModel model = test::RandomModel(3, 0, 3);
  SplatModel before = model;
  std::vector<float> none(model.data.size(), 0.0f);
  test::ModelAdam adam{LearningRates()};
  for (int step = 0; step < 5000; ++step) adam.Step(model, none.data(), model.num_attributes(), 1);
  EXPECT_EQ(model.data, before.data);
  // Unseen parameters stop moving.
  MoveOfOpacity(adam, model, 1e-3f, 0);
  for (int step = 0; step < 5000; ++step) adam.Step(model, none.data(), model.num_attributes(), 1);
  before = model;
  EXPECT_EQ(MoveOfOpacity(adam, model, 0.0f, 0), 0);
  EXPECT_EQ(model.data, before.data);
  for (const float value : model.data) EXPECT_TRUE(std::isfinite(value));
}

}  // namespace
}  // namespace vesta::gs
