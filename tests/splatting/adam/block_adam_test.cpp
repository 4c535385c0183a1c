// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cmath>
#include <numeric>

#include "splatting/adam/adam.h"
#include "splatting/adam/adam_formula.h"
#include "splatting/adam/adam_kernel.h"
#include "tests/splatting/adam/model_adam.h"
#include "tests/support/cpu_isas.h"
#include "tests/support/dense_reference.h"
#include "tests/support/random.h"

namespace vesta::gs {
namespace {

// kBlockSize rows. The compiler would unroll every product of fixed sizes.
using Matrix = Eigen::MatrixXd;
using Vector = Eigen::VectorXd;

Matrix Identity() { return Matrix::Identity(kBlockSize, kBlockSize); }

Matrix RandomMatrix(vesta::test::Random& random) {
  Matrix a(kBlockSize, kBlockSize);
  for (double& value : a.reshaped()) value = random.Normal();
  return a;
}

Matrix RandomRotation(vesta::test::Random& random) { return vesta::test::Orthonormal(RandomMatrix(random)); }

// The arrays of `n` Gaussians, initially without moments.
struct Blocks {
  explicit Blocks(Index n)
      : count(n),
        gradient(Rows()),
        parameters(Rows()),
        first(Rows()),
        second(Rows()),
        bases(static_cast<std::size_t>(BlockArraySize(n))) {
    for (Index i = 0; i < n; ++i) SetBasis(i, Identity());
  }
  std::vector<float> Rows() const { return std::vector<float>(static_cast<std::size_t>(kBlockSize * count)); }
  float& Number(int k, Index i) { return bases[static_cast<std::size_t>(BlockEntry(k, i))]; }
  static float& Entry(std::vector<float>& rows, int k, Index i, Index count) {
    return rows[static_cast<std::size_t>(k * count + i)];
  }
  Vector Of(std::vector<float>& rows, Index i) {
    Vector v(kBlockSize);
    for (int k = 0; k < kBlockSize; ++k) v[k] = Entry(rows, k, i, count);
    return v;
  }
  void SetBasis(Index i, const Matrix& q) {
    for (int k = 0; k < kBasisSize; ++k) Number(k, i) = static_cast<float>(q(k / kBlockSize, k % kBlockSize));
  }
  Matrix Basis(Index i) {
    Matrix q(kBlockSize, kBlockSize);
    for (int k = 0; k < kBasisSize; ++k) q(k / kBlockSize, k % kBlockSize) = Number(k, i);
    return q;
  }
  void SetCovariance(Index i, const Matrix& c) {
    for (int a = 0; a < kBlockSize; ++a) {
      for (int b = 0; b <= a; ++b) Number(kBasisSize + PackedEntry(a, b), i) = static_cast<float>(c(a, b));
    }
  }
  Matrix Covariance(Index i) {
    Matrix c(kBlockSize, kBlockSize);
    for (int a = 0; a < kBlockSize; ++a) {
      for (int b = 0; b < kBlockSize; ++b) c(a, b) = Number(kBasisSize + PackedEntry(a, b), i);
    }
    return c;
  }
  BlockAdamArrays arrays() {
    BlockAdamArrays a{.count = count,
                      .gradient = gradient.data(),
                      .parameters = parameters.data(),
                      .first = first.data(),
                      .second = second.data(),
                      .bases = bases.data(),
                      .bases_begin = 0,
                      .units = nullptr,
                      .rates = {},
                      .step = 1,
                      .beta2 = kAdamBeta2,
                      .root_correction2 = 1};
    for (int k = 0; k < kBlockSize; ++k) a.rates[k] = static_cast<float>(std::pow(1.5, k - 6));
    return a;
  }

  Index count;
  std::vector<float> gradient, parameters, first, second, bases;
};

class BlockAdam : public testing::TestWithParam<Isa> {
 protected:
  AdamKernels kernels_ = AdamKernelsFor(GetParam());
};

// A whole vector of 16, and one among seen ones.
bool IsUnseen(Index i) { return i == 3 || i / 16 == 1; }

TEST_P(BlockAdam, AStepIsTheFormulaInTheBasis) {
  constexpr Index kCount = 37;  // not a multiple of the vector width
  vesta::test::Random random(3);
  Blocks blocks(kCount);
  std::vector<float> units(kCount);
  for (Index i = 0; i < kCount; ++i) {
    units[static_cast<std::size_t>(i)] = 0.5f + 0.1f * static_cast<float>(i);
    blocks.SetBasis(i, RandomRotation(random));
    const Matrix a = RandomMatrix(random);
    blocks.SetCovariance(i, a * a.transpose());
    for (int k = 0; k < kBlockSize; ++k) {
      for (auto* rows : {&blocks.gradient, &blocks.parameters, &blocks.first}) {
        Blocks::Entry(*rows, k, i, kCount) = static_cast<float>(random.Normal());
      }
      if (IsUnseen(i)) Blocks::Entry(blocks.gradient, k, i, kCount) = 0;
      Blocks::Entry(blocks.second, k, i, kCount) = static_cast<float>(random.LogUniform(1e-4, 1));
    }
  }
  Blocks before = blocks;
  BlockAdamArrays arrays = blocks.arrays();
  arrays.units = units.data();
  arrays.step = 0.7f;
  arrays.root_correction2 = 1.3f;
  kernels_.step_blocks(arrays, 0, kCount);
  for (Index i = 0; i < kCount; ++i) {
    Vector rate(kBlockSize);
    for (int k = 0; k < kBlockSize; ++k) {
      rate[k] = arrays.rates[k] * (k < splat::kLogScale ? units[static_cast<std::size_t>(i)] : 1);
    }
    const Vector gradient = before.Of(before.gradient, i), g = rate.cwiseProduct(gradient);
    if (IsUnseen(i)) {
      for (auto [now, then] : {std::pair(&blocks.parameters, &before.parameters),
                               {&blocks.first, &before.first},
                               {&blocks.second, &before.second}}) {
        EXPECT_EQ(blocks.Of(*now, i), before.Of(*then, i)) << i;
      }
      EXPECT_EQ(blocks.Covariance(i), before.Covariance(i)) << i;
      continue;
    }
    const Vector first = 0.7 * before.Of(before.first, i) + 0.3 * gradient;
    const Matrix q = before.Basis(i);
    const Vector turned = q.transpose() * g;
    const Vector second = 0.999 * before.Of(before.second, i) + 0.001 * turned.cwiseProduct(turned);
    Vector scaled = q.transpose() * rate.cwiseProduct(first);
    for (int k = 0; k < kBlockSize; ++k) scaled[k] /= 1.3 * std::sqrt(second[k] + 1e-3 * second.sum());
    const Vector expected = before.Of(before.parameters, i) - 0.7 * rate.cwiseProduct(q * scaled);
    const Matrix covariance = 0.999 * before.Covariance(i) + 0.001 * g * g.transpose();
    EXPECT_LT((blocks.Of(blocks.parameters, i) - expected).norm(), 1e-5 * (1 + expected.norm())) << i;
    EXPECT_LT((blocks.Of(blocks.first, i) - first).norm(), 1e-5 * first.norm()) << i;
    EXPECT_LT((blocks.Of(blocks.second, i) - second).norm(), 1e-5 * second.norm()) << i;
    EXPECT_LT((blocks.Covariance(i) - covariance).norm(), 1e-5 * covariance.norm()) << i;
    EXPECT_EQ(blocks.Of(blocks.gradient, i).norm(), 0) << i;
    EXPECT_EQ(blocks.Basis(i), q) << i;
  }
}

// From any basis, a few rotations converge to the eigenvectors of C, and the second moments to its eigenvalues, for
// scales of C over twelve decades and condition numbers over six.
TEST_P(BlockAdam, TurnsOfTheBasisFindTheEigenvectors) {
  constexpr Index kCount = 35;
  vesta::test::Random random(4);
  Blocks blocks(kCount);
  for (Index i = 0; i < kCount; ++i) {
    const Matrix r = RandomRotation(random);
    Vector values(kBlockSize);
    for (double& value : values) value = random.LogUniform(1e-6, 1);
    blocks.SetCovariance(i, std::pow(10.0, static_cast<double>(i % 13) - 9) * r * values.asDiagonal() * r.transpose());
    if (i % 2 == 0) blocks.SetBasis(i, RandomRotation(random));
  }
  for (int turn = 0; turn < 8; ++turn) kernels_.rotate_bases(blocks.arrays(), 0, kCount);
  for (Index i = 0; i < kCount; ++i) {
    const Matrix q = blocks.Basis(i), c = blocks.Covariance(i);
    EXPECT_LT((q.transpose() * q - Identity()).norm(), 2e-5) << i;
    Matrix turned = q.transpose() * c * q;
    Vector second = blocks.Of(blocks.second, i);
    EXPECT_LT((turned.diagonal() - second).norm(), 1e-5 * c.trace()) << i;
    turned.diagonal().setZero();
    EXPECT_LT(turned.norm(), 1e-5 * c.trace()) << i;
    std::sort(second.begin(), second.end());
    const Vector expected = vesta::test::SymmetricEigenvalues(c);
    EXPECT_LT((second - expected).norm(), 1e-5 * expected.norm()) << i;
  }
}

// C is 0 for a Gaussian never seen, and has rank 1 for one seen once.
TEST_P(BlockAdam, TurnsSurviveSingularCovariances) {
  Blocks blocks(2);
  const Vector g = Vector::LinSpaced(kBlockSize, 1, 11);
  blocks.SetCovariance(1, g * g.transpose());
  for (int turn = 0; turn < 5; ++turn) kernels_.rotate_bases(blocks.arrays(), 0, 2);
  EXPECT_EQ(blocks.Basis(0), Identity());
  const Matrix q = blocks.Basis(1);
  EXPECT_LT((q.transpose() * q - Identity()).norm(), 1e-5);
  EXPECT_NEAR((q.transpose() * g).cwiseAbs().maxCoeff(), g.norm(), 1e-4 * g.norm());
  for (const float value : blocks.second) EXPECT_GE(value, 0);
}

INSTANTIATE_TEST_SUITE_P(Isas, BlockAdam, testing::ValuesIn(vesta::test::CpuIsas()),
                         [](const auto& isa) { return "Isa" + std::to_string(static_cast<int>(isa.param)); });

// One Gaussian with all geometric learning rates 1. Gradients are R A z for random z, with a covariance far from
// diagonal. Returns the total of the last steps, rotated back by R.
Vector TotalStep(SecondMoment metric, const Matrix& r) {
  LearningRates rates;
  rates.position = rates.log_scale = rates.quaternion = rates.opacity = 1;
  SplatModel model;
  model.Resize(0, 1);
  test::ModelAdam adam(rates, metric);
  vesta::test::Random random(5);
  const Matrix shape = RandomMatrix(random);
  std::vector<float> gradient(model.data.size());
  Vector way = Vector::Zero(kBlockSize);
  for (int step = 0; step < 3000; ++step) {
    Vector z(kBlockSize);
    for (double& value : z) value = random.Normal() + 0.3;
    const Vector g = r * shape * z;
    for (int k = 0; k < kBlockSize; ++k) gradient[static_cast<std::size_t>(k)] = static_cast<float>(g[k]);
    Vector before(kBlockSize);
    for (int k = 0; k < kBlockSize; ++k) before[k] = model.data[static_cast<std::size_t>(k)];
    adam.Step(model, gradient.data(), model.num_attributes(), 1e-3);
    if (step < 2000) continue;
    for (int k = 0; k < kBlockSize; ++k) way[k] += model.data[static_cast<std::size_t>(k)] - before[k];
  }
  return r.transpose() * way;
}

// Rotated gradients give rotated steps.
TEST(BlockAdamSteps, TurnWithTheGradients) {
  vesta::test::Random random(6);
  const Matrix turn = RandomRotation(random);
  const Vector way = TotalStep(SecondMoment::kBlock, Identity());
  EXPECT_LT((TotalStep(SecondMoment::kBlock, turn) - way).norm(), 0.02 * way.norm());
  const Vector diagonal = TotalStep(SecondMoment::kDiagonal, Identity());
  EXPECT_GT((TotalStep(SecondMoment::kDiagonal, turn) - diagonal).norm(), 0.2 * diagonal.norm());
}

// The host tests each chunk (IsChunkRotated), a device each view (FirstRotatedChunk).
TEST(BlockAdamSteps, HostAndDeviceRotateTheSameChunks) {
  for (const Index views : {1, 4, 25, 60}) {
    for (Index seen = views; seen < views + 60; ++seen) {
      for (Index chunk = 0; chunk < 2 * kRotationInterval; ++chunk) {
        bool with_any = false;
        for (Index k = 0; k < views; ++k)
          with_any = with_any || FirstRotatedChunk(seen - k) == chunk % kRotationInterval;
        EXPECT_EQ(IsChunkRotated(chunk, seen, views), with_any) << chunk << " " << seen << " " << views;
      }
    }
  }
}

// For any number of views a step.
TEST(BlockAdamSteps, BasesAreRotatedOncePerInterval) {
  constexpr Index kChunks = kRotationInterval + 3;
  const auto rotated_after = [](int views, int steps) {
    SplatModel model;
    model.Resize(0, kChunks * kRotationChunk);
    test::ModelAdam adam({}, SecondMoment::kBlock, views);
    vesta::test::Random random(9);
    for (int step = 0; step < steps; ++step) {
      std::vector<float> gradient = random.NormalVector<float>(model.data.size());
      adam.Step(model, gradient.data(), model.num_attributes(), 1e-3);
    }
    std::vector<Index> turned;
    for (Index chunk = 0; chunk < kChunks; ++chunk) {
      if (adam.adam().bases().At(1, chunk * kRotationChunk) != 0) turned.push_back(chunk);
    }
    return turned;
  };
  EXPECT_EQ(rotated_after(1, 1), (std::vector<Index>{24}));
  EXPECT_EQ(rotated_after(2, 1), (std::vector<Index>{23, 24}));
  EXPECT_EQ(rotated_after(2, 2), rotated_after(1, 4));
  EXPECT_EQ(rotated_after(4, 3), rotated_after(1, 12));
  EXPECT_EQ(rotated_after(25, 1).size(), static_cast<std::size_t>(kChunks));
  EXPECT_EQ(rotated_after(60, 1).size(), static_cast<std::size_t>(kChunks));
}

TEST(BlockAdamSteps, NewGaussiansKeepTheDirectionsOfTheirOrigin) {
  SplatModel model;
  model.Resize(0, 40);
  test::ModelAdam adam({}, SecondMoment::kBlock), reference({}, SecondMoment::kBlock);
  SplatModel same = model;
  vesta::test::Random random(7);
  for (int step = 0; step < 100; ++step) {
    std::vector<float> gradient = random.NormalVector<float>(model.data.size()), copy = gradient;
    adam.Step(model, gradient.data(), model.num_attributes(), 1);
    reference.Step(same, copy.data(), same.num_attributes(), 1);
  }
  const std::vector<Index> source = {39, 3, 3};
  adam.Rearrange(source, {true, true, false});
  model = InOrder(std::move(model), source);
  const BlockBases<Host>&bases = adam.adam().bases(), &origin = reference.adam().bases();
  for (int k = 0; k < kBlockNumbers; ++k) {
    const float old = origin.At(k, 3);
    EXPECT_EQ(bases.At(k, 1), old);
    EXPECT_EQ(bases.At(k, 2), k < kBasisSize ? old : 0);
  }
  const SplatModel before = model;
  std::vector<float> pull(model.data.size(), 1e-3f), same_pull(same.data.size(), 1e-3f);
  adam.Step(model, pull.data(), model.num_attributes(), 1);
  reference.Step(same, same_pull.data(), same.num_attributes(), 1);
  for (int a = 0; a < model.num_attributes(); ++a) {
    // Up to rounding: it may be in a full vector or at the end of the array.
    EXPECT_NEAR(model.attribute(a)[0], same.attribute(a)[39], 1e-6) << a;
    EXPECT_NEAR(model.attribute(a)[1], same.attribute(a)[3], 1e-6) << a;
    EXPECT_NE(model.attribute(a)[2], model.attribute(a)[1]) << "the copy starts without moments";
    EXPECT_NE(model.attribute(a)[1], before.attribute(a)[1]) << a;
  }
}

// In so many pieces that the first are freed before the last are allocated.
TEST(BlockAdamSteps, BasesFollowTheirGaussians) {
  constexpr Index kOld = 5000, kNew = 6100;
  std::vector<float> flat(static_cast<std::size_t>(BlockArraySize(kOld)));
  std::iota(flat.begin(), flat.end(), 1.0f);
  BlockBases<Host> bases(kOld, {flat.data(), static_cast<Index>(flat.size())});
  const HostBuffer<float> given_back = bases.Flat();
  EXPECT_EQ(std::vector<float>(given_back.begin(), given_back.end()), flat);
  const auto old_number = [&](int number, Index i) { return flat[static_cast<std::size_t>(BlockEntry(number, i))]; };
  // Mostly in order, as halves next to each other; some from far away.
  vesta::test::Random random(9);
  std::vector<std::uint32_t> source;
  std::vector<std::uint8_t> keep;
  for (Index i = 0; i < kNew; ++i) {
    source.push_back(
        static_cast<std::uint32_t>(i % 97 == 0 ? static_cast<Index>(random.Uniform(0, kOld)) : i * kOld / kNew));
    keep.push_back(i % 3 != 0 ? 1 : 0);
  }
  bases.Rearrange({source.data(), kNew}, {keep.data(), kNew});
  Index wrong = 0;
  for (Index i = 0; i < kNew; ++i) {
    for (const int number : {0, kBasisSize - 1, kBasisSize, kBlockNumbers - 1}) {
      const bool known = number < kBasisSize || keep[static_cast<std::size_t>(i)] != 0;
      wrong += bases.At(number, i) != (known ? old_number(number, source[static_cast<std::size_t>(i)]) : 0.0f);
    }
  }
  EXPECT_EQ(wrong, 0);
  EXPECT_EQ(static_cast<Index>(bases.Flat().size()), BlockArraySize(kNew));
}

TEST(BlockAdamSteps, UnseenParametersStayForeverAndFinite) {
  SplatModel model;
  model.Resize(0, 3);
  test::ModelAdam adam({}, SecondMoment::kBlock);
  std::vector<float> gradient(model.data.size());
  gradient[1] = 1e-3f;
  adam.Step(model, gradient.data(), model.num_attributes(), 1);
  for (int step = 0; step < 5000; ++step) adam.Step(model, gradient.data(), model.num_attributes(), 1);
  const SplatModel before = model;
  adam.Step(model, gradient.data(), model.num_attributes(), 1);
  EXPECT_EQ(model.data, before.data);
  EXPECT_NE(model.data[1], 0);
  for (const float value : model.data) EXPECT_TRUE(std::isfinite(value));
  EXPECT_EQ(model.data[0], 0);
}

}  // namespace
}  // namespace vesta::gs
