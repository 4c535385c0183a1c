// SPDX-License-Identifier: Apache-2.0
// Views, the loss and the splatting problem on the GPU and on the host.
#include "kernels/gaussian_splatting/device/device_splat_view.h"
#include "kernels/image/device_photometric_loss.h"
#include "problems/gaussian_splatting/model/device_splat_backend.h"
#include "problems/gaussian_splatting/model/splat_model.h"
#include "tests/cuda/on_device.h"
#include "tests/problems/gaussian_splatting/ring_scene.h"
#include "tests/support/linearize_at.h"
#include "tests/support/splat_scenes.h"

namespace vesta::test {
namespace {

// Relative to the norm, in float. Alphas near a threshold may be decided differently.
constexpr double kTolerance = 1e-4;

class CudaView : public OnDevice {};
class CudaLoss : public OnDevice {};
class CudaSplatProblem : public OnDevice {};

TEST_F(CudaView, ImageProductsAndBlocksAreThoseOfTheHost) {
  std::vector<Scene> scenes;
  for (const SceneOptions& options : SceneKinds()) scenes.push_back(RandomScene(options, 8));
  // Different SH degrees, some above the active degree.
  scenes.push_back(WithBands(RandomScene(SceneOptions(), 8), {40, 29, 17, 5}));
  scenes.push_back(scenes.back());
  scenes.back().active_sh_degree = 2;
  for (const Scene& scene : scenes) {
    SCOPED_TRACE(&scene - scenes.data());
    RenderedView<float> host(scene);
    const DeviceBuffer<float> x = ToDevice(host.x);
    const splat::Model<float> model = {x.data(), scene.layout(), scene.active_sh_degree};
    splat::DeviceViewWorkspace workspace;
    splat::DeviceSplatView view;
    view.Build(model, scene.view, scene.background, workspace);
    EXPECT_NEAR(static_cast<double>(view.num_splats()), static_cast<double>(host.view.num_splats()), 1);
    const auto values = static_cast<Index>(host.image.size());
    DeviceBuffer<float> image(values), d_image(values), g(x.size());
    view.Render(image.data());
    EXPECT_LT(RelativeError(ToHost(image), host.image), kTolerance);

    Random random(9);
    const auto v = random.NormalVector<float>(host.x.size()), u = random.NormalVector<float>(host.image.size());
    const DeviceBuffer<float> dv = ToDevice(v), du = ToDevice(u);
    view.ApplyJ(model, dv.data(), d_image.data(), workspace);
    const std::vector<float> Jv = ToHost(d_image);
    EXPECT_LT(RelativeError(Jv, host.ApplyJ(v)), kTolerance);
    view.AddJT(model, image.data(), du.data(), g.data(), workspace);
    const std::vector<float> JTu = ToHost(g);
    EXPECT_LT(RelativeError(JTu, host.ApplyJT(u)), kTolerance);
    // J and J^T on the device are adjoint to each other.
    double left = 0, right = 0, scale = 0;
    for (std::size_t i = 0; i < u.size(); ++i) left += double{u[i]} * Jv[i], scale += std::pow(double{u[i]} * Jv[i], 2);
    for (std::size_t i = 0; i < v.size(); ++i) right += double{v[i]} * JTu[i];
    EXPECT_NEAR(left, right, 1e-4 * std::sqrt(scale));

    std::vector<float> omega = u;
    for (float& value : omega) value *= value;
    const DeviceBuffer<float> device_omega = ToDevice(omega);
    const Index blocks = Index{splat::kGeometry * (splat::kGeometry + 1) / 2} * scene.count;
    std::vector<float> host_blocks(static_cast<std::size_t>(blocks)),
        host_sh(host.x.size() - static_cast<std::size_t>(splat::kSh * scene.count));
    host.view.AddGram(host.model, host.image.data(), omega.data(), host_blocks.data(), host_sh.data(), host.workspace);
    DeviceBuffer<float> device_blocks(blocks), device_sh(static_cast<Index>(host_sh.size()));
    view.AddGram(model, image.data(), device_omega.data(), device_blocks.data(), device_sh.data(), workspace);
    EXPECT_LT(RelativeError(ToHost(device_blocks), host_blocks), 5 * kTolerance);
    EXPECT_LT(RelativeError(ToHost(device_sh), host_sh), 5 * kTolerance);
  }
}

TEST_F(CudaLoss, ValueGradientAndCurvatureAreThoseOfTheHost) {
  const ImageShape shape{75, 53};
  Random random(10);
  std::vector<float> truth, rendered;
  for (Index i = 0; i < shape.NumValues(); ++i) {
    truth.push_back(static_cast<float>(random.Uniform(0, 1)));
    rendered.push_back(static_cast<float>(std::clamp(truth.back() + 0.1 * random.Normal(), 0.0, 1.0)));
  }
  const auto v = random.NormalVector<float>(rendered.size());
  for (const SsimLinearization structure : {SsimLinearization::kQuadratic, SsimLinearization::kRootCenter}) {
    SCOPED_TRACE(static_cast<int>(structure));
    PhotometricLoss<float> host({.structure = structure});
    PhotometricLinearization<float> host_w;
    std::vector<float> gradient(rendered.size()), Wv(rendered.size());
    const PhotometricValue expected =
        host.Linearize(ViewOf(rendered), ViewOf(truth), shape, {gradient.data(), shape.NumValues()}, host_w);
    host.ApplyW(host_w, ViewOf(v), {Wv.data(), shape.NumValues()});

    const DeviceBuffer<float> dx = ToDevice(rendered), dy = ToDevice(truth), dv = ToDevice(v);
    DeviceBuffer<float> device_gradient(shape.NumValues()), device_Wv(shape.NumValues());
    DevicePhotometricLoss loss({.structure = structure});
    DevicePhotometricLinearization w;
    loss.Linearize(dx, dy, shape, device_gradient, w);
    const PhotometricValue found = loss.Value();
    loss.ApplyW(w, dv, device_Wv);
    EXPECT_NEAR(found.cost, expected.cost, kTolerance * expected.cost);
    EXPECT_NEAR(loss.Evaluate(dx, dy, shape).objective, expected.objective, kTolerance * expected.objective);
    EXPECT_LT(RelativeError(ToHost(device_gradient), gradient), kTolerance);
    EXPECT_LT(RelativeError(ToHost(device_Wv), Wv), kTolerance);
  }
}

// The problem at x after OnNewPoint(3), and results computed from its operators.
void ExpectOperatorsOfTheHost(const gs::test::RingProblem<float>& ring) {
  gs::SplatProblem<CpuBackend<float>> host = ring.Make();
  const std::vector<gs::TargetView<CudaBackend<float>>> targets = gs::TargetsIn<CudaBackend<float>>(ring.views);
  gs::SplatProblem<CudaBackend<float>> problem(ring.options, targets);
  DeviceBuffer<float> x;
  x.CopyFrom(ring.x.view());
  const double cost = host.Cost(ring.x);
  EXPECT_NEAR(problem.Cost(x), cost, kTolerance * cost);
  host.OnNewPoint(3);
  problem.OnNewPoint(3);
  const auto expected = LinearizeAt(host, ring.x);
  const auto found = LinearizeAt(problem, x);
  HostBuffer<float> host_vector(ring.x.size()), host_metric(ring.x.size());
  DeviceBuffer<float> device_vector(x.size()), device_metric(x.size());
  expected->Gradient(host_vector);
  found->Gradient(device_vector);
  EXPECT_LT(RelativeError(ToHost(device_vector), host_vector), kTolerance);
  ASSERT_EQ(found->has_own_right_hand_side(), expected->has_own_right_hand_side());
  expected->RightHandSide(host_vector);
  found->RightHandSide(device_vector);
  EXPECT_LT(RelativeError(ToHost(device_vector), host_vector), 10 * kTolerance);
  expected->DiagJTJ(host_vector);
  found->DiagJTJ(device_vector);
  EXPECT_LT(RelativeError(ToHost(device_vector), host_vector), 5 * kTolerance);
  ASSERT_TRUE(host.DampingMetric(ring.x, host_vector, host_metric));
  ASSERT_TRUE(problem.DampingMetric(x, device_vector, device_metric));
  EXPECT_LT(RelativeError(ToHost(device_metric), host_metric), 5 * kTolerance);
  BlockDiagonal<CpuBackend<float>> host_blocks(ring.x.size(), expected->block_groups());
  BlockDiagonal<CudaBackend<float>> device_blocks(x.size(), found->block_groups());
  expected->BlockGram(host_blocks);
  found->BlockGram(device_blocks);
  DeviceBuffer<float> block_values;
  block_values.CopyFrom(Span<const float, Device>(device_blocks.all_values()));
  EXPECT_LT(RelativeError(ToHost(block_values), host_blocks.all_values()), 5 * kTolerance);
  Random random(14);
  const auto v = random.NormalVector<float>(static_cast<std::size_t>(x.size()));
  const DeviceBuffer<float> dv = ToDevice(v);
  expected->ApplyH(ViewOf(v), host_vector);
  found->ApplyH(dv, device_vector);
  const std::vector<float> Hv = ToHost(device_vector);
  EXPECT_LT(RelativeError(Hv, host_vector), 5 * kTolerance);
  // Sums are deterministic.
  DeviceBuffer<float> again(x.size());
  found->ApplyH(dv, again);
  EXPECT_EQ(ToHost(again), Hv);
  // The fused product equals the three products.
  ASSERT_EQ(found->num_residuals(), expected->num_residuals());
  DeviceBuffer<float> Jv(found->num_residuals()), WJv(Jv.size());
  found->ApplyJ(dv, Jv);
  found->ApplyW(Jv, WJv);
  found->ApplyJT(WJv, again);
  EXPECT_LT(RelativeError(ToHost(again), Hv), kTolerance);
}

TEST_F(CudaSplatProblem, CostGradientDiagonalAndCurvatureAreThoseOfTheHost) {
  ExpectOperatorsOfTheHost(gs::test::RingProblem<float>(4, 30, 1, 11));
}

TEST_F(CudaSplatProblem, DegreesMayDiffer) {
  gs::Scene scene = gs::test::RingOfCameras(3, 40, 30, false);
  gs::test::RenderTruth(gs::test::RandomModel(30, 3, 11), 0, &scene);
  const gs::SplatModel mixed = gs::test::WithDegrees(gs::test::RandomModel(30, 3, 12), gs::test::MixedDegrees(30));
  ExpectOperatorsOfTheHost(gs::test::RingProblem<float>(scene, mixed));
}

TEST_F(CudaSplatProblem, ViewsBuiltAnewGiveTheBitsOfThoseThatAreHeld) {
  gs::test::RingProblem<float> ring(3, 30, 2, 20);
  const auto targets = gs::TargetsIn<CudaBackend<float>>(ring.views);
  DeviceBuffer<float> x;
  x.CopyFrom(ring.x.view());
  Random random(21);
  const DeviceBuffer<float> v = ToDevice(random.NormalVector<float>(static_cast<std::size_t>(x.size())));
  std::vector<std::vector<float>> results;
  for (const gs::JacobianKind kind : {gs::JacobianKind::kCachedViews, gs::JacobianKind::kOnTheFly}) {
    ring.options.jacobian = kind;
    gs::SplatProblem<CudaBackend<float>> problem(ring.options, targets);
    const auto linearization = LinearizeAt(problem, x);
    std::vector<float>& all = results.emplace_back();
    const auto keep = [&](const DeviceBuffer<float>& values) {
      const std::vector<float> on_host = ToHost(values);
      all.insert(all.end(), on_host.begin(), on_host.end());
    };
    DeviceBuffer<float> of_x(x.size()), of_residuals(linearization->num_residuals()), weighted(of_residuals.size());
    for (int again = 0; again < 2; ++again) {
      linearization->ApplyH(v, of_x);
      keep(of_x);
    }
    linearization->Gradient(of_x);
    keep(of_x);
    linearization->DiagJTJ(of_x);
    keep(of_x);
    linearization->ApplyJ(v, of_residuals);
    keep(of_residuals);
    linearization->ApplyW(of_residuals, weighted);
    keep(weighted);
    linearization->ApplyJT(weighted, of_x);
    keep(of_x);
    weighted.CopyFrom(linearization->residuals());
    keep(weighted);
  }
  EXPECT_TRUE(results[0] == results[1]);
}

TEST_F(CudaSplatProblem, VariantsAreThoseOfTheHost) {
  struct Variant {
    const char* name;
    void (*apply)(gs::SplatProblemOptions&);
  };
  const Variant variants[] = {
      {"agreement of views", [](gs::SplatProblemOptions& o) { o.gradient_shrinkage = 0.3; }},
      {"cache32", [](gs::SplatProblemOptions& o) { o.jacobian = gs::JacobianKind::kCache32; }},
      {"cache16", [](gs::SplatProblemOptions& o) { o.jacobian = gs::JacobianKind::kCache16; }},
      {"batches",
       [](gs::SplatProblemOptions& o) {
         o.batches = {2, 1, gs::BatchChoice::kRandom, 3};
       }},
      {"root by centres", [](gs::SplatProblemOptions& o) { o.weights.structure = SsimLinearization::kRootCenter; }},
  };
  for (const Variant& variant : variants) {
    SCOPED_TRACE(variant.name);
    gs::test::RingProblem<float> ring(3, 30, 1, 13);
    variant.apply(ring.options);
    ExpectOperatorsOfTheHost(ring);
  }
}

}  // namespace
}  // namespace vesta::test
