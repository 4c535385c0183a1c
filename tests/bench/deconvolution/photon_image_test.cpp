// SPDX-License-Identifier: Apache-2.0
#include "bench/deconvolution/photon_image.h"

#include <gtest/gtest.h>

#include <cmath>

#include "kernels/core/check.h"
#include "kernels/math/dual.h"
#include "solver/check_problem.h"
#include "solver/compose.h"
#include "solver/derivative_check.h"
#include "solver/levenberg_marquardt.h"
#include "tests/support/any_threads.h"
#include "tests/support/linearize_at.h"

namespace vesta::deconvolution {
namespace {

using B = CpuBackend<double>;

constexpr Index kSide = 64;
constexpr int kFrames = 3;

// Pixel (row, column) of A_f x by definition; light(k) is pixel k of x.
template <class T, class Light>
T BlurredPixel(Index side, const Aperture& aperture, Index row, Index column, const Light& light) {
  T sum(0);
  for (Index p = 0; p < kTaps; ++p) {
    for (Index q = 0; q < kTaps; ++q) {
      const Index i = row - p, j = column - q;
      if (i < 0 || i >= side || j < 0 || j >= side) continue;
      sum = sum + T(aperture.column[static_cast<std::size_t>(p)] * aperture.row[static_cast<std::size_t>(q)]) *
                      light(i * side + j);
    }
  }
  return sum;
}

PhotonImage MakeProblem(Index side, int frames = kFrames) {
  const auto apertures = CodedApertures(frames);
  return {side, apertures, Expose(side, apertures, TestScene(side))};
}

// Logarithms of other light intensities than the scene's.
B::Vector SomePoint(Index side) {
  B::Vector x(side * side);
  B backend;
  FillRandom(backend, 11, x.view());
  const auto scene = TestScene(side);
  for (Index k = 0; k < x.size(); ++k) x[k] = std::log(scene[k]) + 0.3 * x[k];
  return x;
}

TEST(CodedBlur, IsTheSumOverTheAperture) {
  // Narrower than a vector, odd, and wider than a kernel's tile.
  for (const Index side : {Index{1}, Index{3}, Index{30}, Index{61}, Index{283}}) {
    const auto apertures = CodedApertures(2);
    const auto scene = TestScene(side);
    const auto frames = Expose(side, apertures, scene);
    const CodedBlur shape(side, apertures);
    for (Index i = 0; i < frames.size(); i += side < 100 ? 1 : 101) {
      const auto f = static_cast<std::size_t>(i / shape.frame_size());
      const Index pixel = i % shape.frame_size();
      const double expected = BlurredPixel<double>(side, apertures[f], pixel / shape.frame_side(),
                                                   pixel % shape.frame_side(), [&](Index k) { return scene[k]; });
      ASSERT_NEAR(frames[i], expected, 1e-13 * 400) << "side " << side << ", value " << i;
    }
  }
}

TEST(CodedBlur, EigenvaluesLieWithinTheSymbol) {
  const auto apertures = CodedApertures(kFrames);
  const SymbolRange range = NormalSymbol(apertures);
  EXPECT_GT(range.least, 1e-3);
  EXPECT_EQ(range.greatest, kFrames);
  CodedBlur blur(kSide, apertures);
  B backend;
  B::Vector v(blur.image_size()), product(blur.image_size()), frame(blur.frame_size());
  const auto rayleigh = [&] {
    blur.SetImage([&](Index k) { return v[k]; });
    for (int f = 0; f < kFrames; ++f) {
      blur.Blur(f, frame);
      blur.SetFrame([&](Index i) { return frame[i]; });
      blur.AddAdjoint(f, f == 0, product);
    }
    return backend.Dot(v, product) / backend.Dot(v, v);
  };
  // The largest eigenvalue by the power method, and the smallest by the power method for kFrames I minus the operator.
  for (const bool upwards : {true, false}) {
    FillRandom(backend, 3, v.view());
    double value = 0;
    for (int i = 0; i < 100; ++i) {
      value = rayleigh();
      EXPECT_LE(value, range.greatest);
      EXPECT_GE(value, range.least);
      backend.Axpby(upwards ? 0 : kFrames, v, upwards ? 1 : -1, product);
      backend.Axpby(1 / backend.MaxAbs(product), product, 0, v);
    }
    if (upwards) {
      EXPECT_GT(value, 0.5 * range.greatest);
    } else {
      EXPECT_LT(value, 0.1 * range.greatest);
    }
  }
}

TEST(PhotonImage, JacobianIsTheDerivative) {
  const auto apertures = CodedApertures(kFrames);
  PhotonImage problem = MakeProblem(kSide);
  B backend;
  const B::Vector x = SomePoint(kSide);
  B::Vector v(x.size()), u(problem.num_residuals());
  FillRandom(backend, 5, v.view());
  const auto linearization = LinearizeAt(problem, x);
  linearization->ApplyJ(v, u);
  const double scale = backend.MaxAbs(u);
  const auto counts = Expose(kSide, apertures, TestScene(kSide));
  const Index frame_size = problem.blur().frame_size(), frame_side = problem.blur().frame_side();
  for (Index i = 0; i < u.size(); i += 37) {
    const auto y = BlurredPixel<Dual<double>>(kSide, apertures[static_cast<std::size_t>(i / frame_size)],
                                              i % frame_size / frame_side, i % frame_side,
                                              [&](Index k) { return exp(Dual<double>(x[k], v[k])); });
    const auto r = Dual<double>(2) * sqrt(y + Dual<double>(0.375)) - Dual<double>(2 * std::sqrt(counts[i] + 0.375));
    ASSERT_NEAR(linearization->residuals()[i], r.a, 1e-11);
    ASSERT_NEAR(u[i], r.v, 1e-9 * std::max(std::abs(r.v), 1e-3 * scale));
  }
}

TEST(PhotonImage, HasNoFault) {
  PhotonImage problem = MakeProblem(kSide);
  B backend;
  CheckProblemOptions options;
  options.max_columns = 20;
  const ProblemCheck check = CheckProblem<B>(backend, problem, SomePoint(kSide), options);
  EXPECT_TRUE(check.ok()) << check.Report();
}

TEST(PhotonImage, ProductsAgree) {
  PhotonImage problem = MakeProblem(kSide);
  B backend;
  const B::Vector x = SomePoint(kSide);
  const auto linearization = LinearizeAt(problem, x);
  JacobianMap<B> jacobian(linearization->get());
  EXPECT_LE(WorstAdjointError<B>(backend, jacobian, 7), 1e-12);
  EXPECT_LE(DiagonalError<B>(backend, linearization->get(), 0, 61), 1e-10);
  // The fused product with H equals the two products.
  B::Vector v(x.size()), u(problem.num_residuals()), two(x.size()), fused(x.size());
  FillRandom(backend, 9, v.view());
  linearization->ApplyJ(v, u);
  linearization->ApplyJT(u, two);
  linearization->ApplyH(v, fused);
  const double scale = backend.MaxAbs(two);
  backend.Axpby(-1, two, 1, fused);
  EXPECT_LE(backend.MaxAbs(fused), 1e-13 * scale);
}

TEST(PhotonImage, EntriesOfTheJacobianAreCounted) {
  constexpr Index kSmall = 5;
  PhotonImage problem = MakeProblem(kSmall);
  const auto linearization = LinearizeAt(problem, SomePoint(kSmall));
  Index entries = 0;
  B::Vector unit(kSmall * kSmall), column(problem.num_residuals());
  for (Index k = 0; k < unit.size(); ++k) {
    unit[k] = 1;
    linearization->ApplyJ(unit, column);
    unit[k] = 0;
    for (const double value : column) entries += value != 0;
  }
  EXPECT_EQ(problem.jacobian_entries(), entries);
  EXPECT_EQ(problem.stored_jacobian_bytes(), static_cast<double>(12 * entries + 4 * (problem.num_residuals() + 1)));
}

// As in the benchmark, from a uniform start.
TEST(PhotonImage, RecoversTheImageWithTheSameBitsOnAnyNumberOfThreads) {
  const auto scene = TestScene(kSide);
  test::ExpectSameForAnyThreads([&] {
    PhotonImage problem = MakeProblem(kSide);
    B backend;
    B::Vector x(problem.num_parameters());
    backend.Fill(problem.UniformStart(), x);
    const LmSummary summary = SolveLm(PhotonImageOptions(), backend, problem, x.view());
    EXPECT_TRUE(IsConverged(summary.status)) << summary.FullReport();
    double worst = 0;
    for (Index k = 0; k < x.size(); ++k) worst = std::max(worst, std::abs(std::exp(x[k]) / scene[k] - 1));
    EXPECT_LE(worst, 1e-6) << summary.FullReport();
    return std::vector<double>(x.begin(), x.end());
  });
}

TEST(PhotonImage, RefusesWrongSizes) {
  EXPECT_THROW(PhotonImage(8, CodedApertures(2), HostBuffer<double>(10)), Error);
  EXPECT_THROW(CodedBlur(0, CodedApertures(1)), Error);
  EXPECT_THROW(CodedApertures(0), Error);
  PhotonImage problem = MakeProblem(kSide);
  const B::Vector x(5);
  EXPECT_THROW(problem.Cost(x), Error);
  EXPECT_THROW(LinearizeAt(problem, x), Error);
}

}  // namespace
}  // namespace vesta::deconvolution
