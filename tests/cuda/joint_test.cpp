// SPDX-License-Identifier: Apache-2.0
// The joint problem of Gaussians and cameras on the GPU and on the host.
#include <memory>
#include <utility>
#include <vector>

#include "kernels/core/device_kernels.h"
#include "problems/gaussian_splatting/model/device_splat_backend.h"
#include "solver/problem.h"
#include "solver/reduced_system.h"
#include "tests/cuda/on_device.h"
#include "tests/splatting/cameras/joint_setup.h"
#include "tests/support/linearize_at.h"
#include "tests/support/splat_scenes.h"

namespace vesta::test {
namespace {

using Cpu = CpuBackend<float>;
using Gpu = CudaBackend<float>;

// Relative to the norm, in float, with cancellation in sums over all Gaussians.
constexpr double kJointTolerance = 1e-3;

class CudaJointProblem : public OnDevice {};

// All parts have similar size.
std::vector<float> StepOf(Index size, std::uint64_t seed) { return Random(seed).NormalVector<float>(size); }

// A joint problem on one backend, with host vectors.
template <class B>
class Asked {
 public:
  using Vector = typename B::Vector;

  Asked(const gs::test::JointSetup<float>& setup, bool eliminates)
      : views_(gs::TargetsIn<B>(setup.ring.views)), x_(There(Values(setup.x))) {
    gs::JointProblemOptions options = setup.options;
    options.eliminate_views = eliminates;
    options.splats.gradient_shrinkage = 0.5;
    problem_ = std::make_unique<gs::JointProblem<B>>(options, views_);
    at_ = LinearizeAt(*problem_, x_);
  }
  double Cost() { return problem_->Cost(x_); }
  const gs::JointLayout& layout() const { return problem_->layout(); }
  std::vector<BlockGroup> block_groups() const { return problem_->block_groups(); }
  Index num_parameters() const { return problem_->num_parameters(); }
  Index num_tangent() const { return problem_->num_tangent(); }
  Index num_residuals() const { return at_->num_residuals(); }
  std::vector<float> Residuals() const { return Here(at_->residuals()); }
  std::vector<float> Plus(const std::vector<float>& step) {
    B backend;
    return Made(problem_->num_parameters(), [&](auto to) { problem_->Plus(backend, x_, There(step), to); });
  }
  std::vector<float> ApplyJ(const std::vector<float>& v) {
    return Made(num_residuals(), [&](auto to) { at_->ApplyJ(There(v), to); });
  }
  std::vector<float> ApplyJT(const std::vector<float>& u) {
    return Tangent([&](auto to) { at_->ApplyJT(There(u), to); });
  }
  std::vector<float> ApplyW(const std::vector<float>& u) {
    return Made(num_residuals(), [&](auto to) { at_->ApplyW(There(u), to); });
  }
  std::vector<float> ApplyH(const std::vector<float>& v) {
    return Tangent([&](auto to) { at_->ApplyH(There(v), to); });
  }
  std::vector<float> Gradient() {
    return Tangent([&](auto to) { at_->Gradient(to); });
  }
  std::vector<float> RightHandSide() {
    return Tangent([&](auto to) { at_->RightHandSide(to); });
  }
  std::vector<float> Diagonal() {
    return Tangent([&](auto to) { at_->DiagJTJ(to); });
  }
  std::vector<float> Blocks() {
    BlockDiagonal<B> blocks(num_tangent(), problem_->block_groups());
    at_->BlockGram(blocks);
    return Here(blocks.all_values());
  }
  // With views eliminated: right-hand side, a product, diagonal blocks, and a complete step.
  std::vector<std::vector<float>> Reduced(const std::vector<float>& rhs, const std::vector<float>& step) {
    const Vector metric = There(Diagonal());
    const auto system = at_->MakeReducedSystem();
    system->SetDamping(0.1, metric);
    const Index n = system->size();
    const std::vector<float> kept(step.begin(), step.begin() + n);
    BlockDiagonal<B> blocks(n, system->kept_groups());
    system->DiagonalBlocks(blocks);
    Vector whole = There(step);
    system->BackSubstitute(There(rhs), whole);
    return {Made(n, [&](auto to) { system->ReduceRhs(There(rhs), to); }),
            Made(n, [&](auto to) { system->Apply(There(kept), to); }), Here(blocks.all_values()), Here(whole)};
  }

  std::int64_t WaitsOfApplyH() {
    const Vector v = There(StepOf(num_tangent(), 3));
    Vector to(num_tangent());
    return Waits([&] { at_->ApplyH(v, to); });
  }
  std::int64_t WaitsOfReducedApply() {
    const Vector metric = There(Diagonal());
    const auto system = at_->MakeReducedSystem();
    system->SetDamping(0.1, metric);
    const Vector v = There(StepOf(system->size(), 3));
    Vector to(system->size());
    return Waits([&] { system->Apply(v, to); });
  }

 private:
  template <class Call>
  static std::int64_t Waits(const Call& call) {
    call();  // allocates work space
    const std::int64_t before = device::CountedHostWork().waits;
    call();
    return device::CountedHostWork().waits - before;
  }
  static std::vector<float> Values(const HostBuffer<float>& v) { return {v.begin(), v.end()}; }
  static Vector There(const std::vector<float>& v) {
    Vector vector;
    vector.CopyFrom(ViewOf(v));
    return vector;
  }
  static std::vector<float> Here(typename B::ConstVectorView v) {
    std::vector<float> here(static_cast<std::size_t>(v.size()));
    B().ToHost(v, {here.data(), v.size()});
    return here;
  }
  template <class Make>
  static std::vector<float> Made(Index size, const Make& make) {
    Vector to(size);
    make(to.view());
    return Here(to);
  }
  template <class Make>
  std::vector<float> Tangent(const Make& make) {
    return Made(num_tangent(), make);
  }

  std::vector<gs::TargetView<B>> views_;
  Vector x_;
  std::unique_ptr<gs::JointProblem<B>> problem_;
  std::unique_ptr<LinearizationAdaptor<B>> at_;
};

// Part by part, because splats and pixels would hide errors in the few camera and prior values.
class Comparison {
 public:
  explicit Comparison(std::vector<Index> parts) : parts_(std::move(parts)) {}

  void operator()(const std::vector<float>& found, const std::vector<float>& expected, const char* what) const {
    ASSERT_EQ(found.size(), expected.size()) << what;
    auto at = found.begin(), expected_at = expected.begin();
    for (const Index size : parts_) {
      EXPECT_LT(RelativeError(std::vector<float>(at, at + size), std::vector<float>(expected_at, expected_at + size)),
                kJointTolerance)
          << what << ", " << size << " of " << found.size();
      at += size, expected_at += size;
    }
    EXPECT_EQ(at, found.end()) << what;
  }

 private:
  std::vector<Index> parts_;
};

std::vector<Index> ValuesOf(const std::vector<BlockGroup>& groups) {
  std::vector<Index> values;
  values.reserve(groups.size());
  for (const BlockGroup& group : groups) values.push_back(group.NumValues());
  return values;
}

void ExpectAlike(const gs::test::JointSetup<float>& setup, bool eliminates) {
  Asked<Cpu> host(setup, eliminates);
  Asked<Gpu> device(setup, eliminates);
  EXPECT_NEAR(device.Cost(), host.Cost(), 1e-4 * host.Cost());
  ASSERT_EQ(device.num_residuals(), host.num_residuals());
  ASSERT_EQ(device.num_tangent(), host.num_tangent());
  const gs::JointLayout& layout = host.layout();
  const Index splats = layout.splats, priors = layout.views * layout.free.num_tangent();
  const std::vector<float> v = StepOf(host.num_tangent(), 3), u = StepOf(host.num_residuals(), 4);
  const Comparison residuals({host.num_residuals() - priors, priors}),
      parameters({splats, host.num_parameters() - splats}), steps({splats, host.num_tangent() - splats}),
      blocks(ValuesOf(host.block_groups()));
  residuals(device.Residuals(), host.Residuals(), "residuals");
  parameters(device.Plus(v), host.Plus(v), "x (+) v");
  residuals(device.ApplyJ(v), host.ApplyJ(v), "J v");
  steps(device.ApplyJT(u), host.ApplyJT(u), "J^T u");
  residuals(device.ApplyW(u), host.ApplyW(u), "W u");
  steps(device.ApplyH(v), host.ApplyH(v), "H v");
  steps(device.Gradient(), host.Gradient(), "gradient");
  steps(device.RightHandSide(), host.RightHandSide(), "descent");
  steps(device.Diagonal(), host.Diagonal(), "diagonal");
  blocks(device.Blocks(), host.Blocks(), "blocks");
  if (!eliminates) return;
  std::vector<BlockGroup> groups = host.block_groups();
  groups.pop_back();
  const Comparison reduced({splats}), reduced_blocks(ValuesOf(groups));
  const auto found = device.Reduced(v, v), expected = host.Reduced(v, v);
  reduced(found[0], expected[0], "right-hand side without views");
  reduced(found[1], expected[1], "S v");
  reduced_blocks(found[2], expected[2], "blocks without views");
  steps(found[3], expected[3], "step with views");
}

TEST_F(CudaJointProblem, IsThatOfTheHost) {
  for (const gs::FreeUnknowns free : {gs::FreeUnknowns(), gs::FreeUnknowns{true, true}}) {
    SCOPED_TRACE(free.num_tangent());
    gs::test::JointSetup<float> setup(free, 4, 40, 2, 5);
    // Masked pixels of a view.
    std::vector<std::uint8_t> mask;
    for (Index i = 0; i < setup.ring.views[1].shape().PlaneSize(); ++i) mask.push_back(i % 5 == 0 ? 0 : 1);
    setup.ring.views[1].mask = ViewOf(mask);
    for (const bool eliminates : {true, false}) ExpectAlike(setup, eliminates);
  }
}

// As in docs/cuda.md, a product waits for the non-splat parts of the vectors, and for each view's sums over images and
// splats.
TEST_F(CudaJointProblem, AProductWaitsFewTimes) {
  for (const gs::FreeUnknowns free : {gs::FreeUnknowns(), gs::FreeUnknowns{true, true}}) {
    const gs::test::JointSetup<float> setup(free, 4, 40, 2, 5);
    Asked<Gpu> device(setup, true);
    EXPECT_EQ(device.WaitsOfApplyH(), 2 + 4 * ((free.color ? 1 : 0) + 1));
    EXPECT_EQ(device.WaitsOfReducedApply(), 4);
  }
}

}  // namespace
}  // namespace vesta::test
