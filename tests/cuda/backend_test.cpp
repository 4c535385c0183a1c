// SPDX-License-Identifier: Apache-2.0
// Vector algebra, block-diagonal matrices and sorting on the GPU and on the host.
#include <algorithm>
#include <limits>
#include <numeric>

#include "kernels/core/block_diagonal.h"
#include "kernels/core/cuda_backend.h"
#include "kernels/core/device_sort.h"
#include "tests/cuda/on_device.h"
#include "tests/support/random.h"

namespace vesta {
namespace {

using test::RelativeError;
using test::ToDevice;
using test::ToHost;
using test::ViewOf;

template <class S>
class CudaBackendTest : public test::OnDevice {
 protected:
  using Gpu = CudaBackend<S>;
  using Cpu = CpuBackend<S>;
  // Several chunks of a reduction, and not a multiple of the block size.
  static constexpr Index kLong = 100'003;

  // op(backend, x, y) on host and device gives the same y.
  template <class Op>
  void ExpectSame(const Op& op) {
    test::Random random(1);
    const auto x = random.NormalVector<S>(kLong), y = random.NormalVector<S>(kLong);
    HostBuffer<S> expected;
    expected.CopyFrom(ViewOf(y));
    Cpu cpu;
    op(cpu, ViewOf(x), expected.view());
    DeviceBuffer<S> on_device = ToDevice(y);
    const DeviceBuffer<S> device_x = ToDevice(x);
    Gpu gpu;
    op(gpu, device_x.view(), on_device.view());
    EXPECT_LE(RelativeError(ToHost(on_device), expected), 2 * std::numeric_limits<S>::epsilon());
  }
};
using Scalars = testing::Types<float, double>;
TYPED_TEST_SUITE(CudaBackendTest, Scalars);

TYPED_TEST(CudaBackendTest, ElementwiseOperationsAreThoseOfTheHost) {
  this->ExpectSame([](auto& b, auto, auto y) { b.Fill(3, y); });
  this->ExpectSame([](auto& b, auto x, auto y) { b.Copy(x, y); });
  this->ExpectSame([](auto& b, auto x, auto y) { b.Axpby(2, x, -0.5, y); });
  this->ExpectSame([](auto& b, auto x, auto y) { b.Axpby(2, x, 0, y); });
  this->ExpectSame([](auto& b, auto x, auto y) { b.AddScaled(0.3, x, x, y); });
  this->ExpectSame([](auto& b, auto x, auto y) { b.Multiply(x, x, y); });
  this->ExpectSame([](auto& b, auto x, auto y) { b.DivideOrZero(x, y, y); });
  this->ExpectSame([](auto& b, auto x, auto y) { b.Clamp(x, -0.5, 0.5, y); });
  this->ExpectSame([](auto& b, auto x, auto y) { b.Maximum(x, y); });
  this->ExpectSame([](auto& b, auto x, auto y) { b.ClampedInverse(x, 0.1, 2, y); });
  this->ExpectSame([](auto& b, auto x, auto y) { b.SelectPositive(x, 1, 2, y); });
  this->ExpectSame([](auto& b, auto x, auto y) {
    b.Multiply(x, x, y);
    b.Sqrt(y, y);
  });
  this->ExpectSame([](auto& b, auto x, auto y) {
    b.Multiply(x, x, y);
    b.ClampRelative(x, y, -1, 1, y);
  });
}

TYPED_TEST(CudaBackendTest, ReductionsAreThoseOfTheHostAndTheSameEveryTime) {
  using S = TypeParam;
  test::Random random(2);
  CudaBackend<S> gpu;
  CpuBackend<S> cpu;
  for (const std::size_t size :
       {std::size_t{0}, std::size_t{1}, std::size_t{4096}, std::size_t{4097}, std::size_t{1'000'003}}) {
    auto x = random.NormalVector<S>(size), y = random.NormalVector<S>(size);
    const DeviceBuffer<S> dx = ToDevice(x), dy = ToDevice(y);
    double scale = 1e-30;
    for (std::size_t i = 0; i < size; ++i) scale += std::abs(static_cast<double>(x[i]) * static_cast<double>(y[i]));
    const double dot = gpu.Dot(dx.view(), dy.view());
    EXPECT_NEAR(dot, cpu.Dot(ViewOf(x), ViewOf(y)), 1e-13 * scale) << size;
    EXPECT_EQ(gpu.Dot(dx.view(), dy.view()), dot);
    EXPECT_NEAR(gpu.WeightedDot(dx.view(), dx.view(), dy.view()), cpu.WeightedDot(ViewOf(x), ViewOf(x), ViewOf(y)),
                1e-12 * scale);
    EXPECT_EQ(gpu.MaxAbs(dx.view()), cpu.MaxAbs(ViewOf(x)));
    EXPECT_EQ(gpu.CountNonPositive(dx.view()), cpu.CountNonPositive(ViewOf(x)));
    EXPECT_TRUE(gpu.AllFinite(dx.view()));
    if (size == 0) continue;
    x[size / 2] = std::numeric_limits<S>::quiet_NaN();
    const DeviceBuffer<S> bad = ToDevice(x);
    EXPECT_FALSE(gpu.AllFinite(bad.view()));
    EXPECT_TRUE(std::isnan(gpu.MaxAbs(bad.view())));
  }
}

TYPED_TEST(CudaBackendTest, SlotsKeepTheContract) {
  using S = TypeParam;
  CudaBackend<S> gpu;
  typename CudaBackend<S>::Slots slots;
  const std::vector<double> start = {0.0, 2.0, 7.0};
  gpu.Write(ViewOf(start), slots);
  EXPECT_EQ(gpu.Read(slots), start);
  EXPECT_EQ(gpu.Read(gpu.SlotOf(slots, 2)), 7);
  EXPECT_EQ(gpu.ReadLagged(gpu.SlotOf(slots, 1)), 0);
  EXPECT_EQ(gpu.ReadLagged(gpu.SlotOf(slots, 1)), 2);
  gpu.Write(ViewOf(start), slots);
  EXPECT_EQ(gpu.ReadLagged(gpu.SlotOf(slots, 1)), 0) << "must not return a value of an earlier solve";

  const S nan = std::numeric_limits<S>::quiet_NaN();
  const DeviceBuffer<S> bad = ToDevice(std::vector<S>{nan, nan});
  DeviceBuffer<S> x = ToDevice(std::vector<S>{1, 2}), r = ToDevice(std::vector<S>{3, 4}),
                  p = ToDevice(std::vector<S>{nan, nan});
  gpu.CgStep(gpu.SlotOf(slots, 0), bad, bad, x, r);
  gpu.CgDirection(x, gpu.SlotOf(slots, 0), p);
  EXPECT_EQ(ToHost(p), (std::vector<S>{1, 2}));
  gpu.CgStep(gpu.SlotOf(slots, 1), p, p, x, r);
  EXPECT_EQ(ToHost(x), (std::vector<S>{3, 6}));
  EXPECT_EQ(ToHost(r), (std::vector<S>{1, 0}));
}

TYPED_TEST(CudaBackendTest, BlockDiagonalMatricesAreThoseOfTheHost) {
  using S = TypeParam;
  test::Random random(3);
  for (const int order : {1, 3, 4, 5, 9, 11, 16, 17}) {
    const Index count = 300;
    const std::vector<BlockGroup> groups = {{.size = order, .count = count, .offset = 0, .component_stride = count}};
    const Index n = count * order;
    BlockDiagonal<CpuBackend<S>> cpu(n, groups);
    BlockDiagonal<CudaBackend<S>> gpu(n, groups);
    // Positive definite matrices.
    for (Index i = 0; i < count; ++i) {
      const auto a = random.NormalVector<S>(std::size_t{289});
      const auto at = [&a](int row, int k) {
        return a[static_cast<std::size_t>(17) * static_cast<std::size_t>(row) + static_cast<std::size_t>(k)];
      };
      for (int row = 0; row < order; ++row) {
        for (int col = 0; col <= row; ++col) {
          S sum = row == col ? S(0.5) : S(0);
          for (int k = 0; k < order; ++k) {
            sum += at(row, k) * at(col, k);
          }
          cpu.values(0)[PackedLower(row, col) * count + i] = sum;
        }
      }
    }
    CudaBackend<S>().FromHost(cpu.all_values(), gpu.all_values());
    const auto x = random.NormalVector<S>(static_cast<std::size_t>(n));
    const DeviceBuffer<S> dx = ToDevice(x);
    std::vector<S> expected(x.size());
    DeviceBuffer<S> found(n);
    cpu.Apply(ViewOf(x), {expected.data(), n});
    gpu.Apply(dx, found);
    EXPECT_LE(RelativeError(ToHost(found), expected), 20 * std::numeric_limits<S>::epsilon()) << order;
    EXPECT_EQ(cpu.Factorize(), gpu.Factorize());
    cpu.Solve(ViewOf(x), {expected.data(), n});
    gpu.Solve(dx, found);
    EXPECT_LE(RelativeError(ToHost(found), expected), 1e4 * std::numeric_limits<S>::epsilon()) << order;
  }
}

class CudaSort : public test::OnDevice {};

TEST_F(CudaSort, SortsByTheLowestBitsAndKeepsTheOrderOfEqualKeys) {
  test::Random random(4);
  std::vector<std::uint32_t> keys, values;
  for (std::uint32_t i = 0; i < 50'000; ++i) {
    keys.push_back(static_cast<std::uint32_t>(random.Uniform(0, 300)));
    values.push_back(i);
  }
  std::vector<std::size_t> order(keys.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return keys[a] < keys[b]; });
  const auto count = static_cast<Index>(keys.size());
  DeviceBuffer<std::uint32_t> device_keys = ToDevice(keys), device_values = ToDevice(values), other_keys(count),
                              other_values(count);
  DeviceBuffer<unsigned char> temporary;
  device::SortPairs(device_keys, device_values, other_keys, other_values, count, 9, temporary);
  const std::vector<std::uint32_t> sorted = ToHost(device_values);
  for (std::size_t i = 0; i < order.size(); ++i) ASSERT_EQ(sorted[i], order[i]) << i;
}

TEST_F(CudaSort, RunningSumsStartAtZero) {
  const std::vector<Index> counts = {3, 0, 5, 1};
  const DeviceBuffer<Index> in = ToDevice(counts);
  DeviceBuffer<Index> out(4);
  DeviceBuffer<unsigned char> temporary;
  device::RunningSum(in.data(), out.data(), 4, temporary);
  EXPECT_EQ(ToHost(out), (std::vector<Index>{0, 3, 3, 8}));
}

}  // namespace
}  // namespace vesta
