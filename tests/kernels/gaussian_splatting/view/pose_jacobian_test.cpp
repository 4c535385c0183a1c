// SPDX-License-Identifier: Apache-2.0
// The derivative of the image by the pose agrees with Jets and differences, and its products are adjoint.
#include <ceres/jet.h>
#include <ceres/rotation.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

#include "kernels/gaussian_splatting/formulas/color.h"
#include "kernels/gaussian_splatting/projection/camera_motion.h"
#include "kernels/gaussian_splatting/projection/project_kernels.h"
#include "kernels/gaussian_splatting/view/camera_jacobian.h"
#include "tests/kernels/gaussian_splatting/image_derivative.h"
#include "tests/kernels/gaussian_splatting/projection_rows.h"
#include "tests/support/adjoint.h"
#include "tests/support/any_threads.h"
#include "tests/support/cpu_isas.h"
#include "tests/support/splat_scenes.h"

namespace vesta::splat {
namespace {

using test::RenderedView;
using test::Scene;
using test::SceneOptions;
using PoseJet = ceres::Jet<double, kPoseTangent>;

// The nine splat values of Gaussian i by the pose: projects with exp(xi) applied to the view's pose.
void PoseJetRows(const Scene& scene, int i, double K[kSplatTangent][kPoseTangent]) {
  CameraConstants<PoseJet, Pinhole<double>> camera{};
  camera.lens = Pinhole<double>(scene.view.lens, scene.view.width, scene.view.height);
  SetEps2d(scene.view.eps2d, camera);
  camera.antialiased = scene.view.antialiased;
  PoseJet turn[9];
  const PoseJet omega[3] = {PoseJet(0, 0), PoseJet(0, 1), PoseJet(0, 2)};
  ceres::AngleAxisToRotationMatrix(omega, ceres::RowMajorAdapter3x3(turn));
  for (int r = 0; r < 3; ++r) {
    camera.T[r] = PoseJet(0, 3 + r);
    for (int k = 0; k < 3; ++k) {
      camera.T[r] += turn[3 * r + k] * scene.view.T[k];
      for (int c = 0; c < 3; ++c) camera.R[3 * r + c] += turn[3 * r + k] * scene.view.R[3 * k + c];
    }
  }
  for (int c = 0; c < 3; ++c) {
    for (int r = 0; r < 3; ++r) camera.centre[c] -= camera.R[3 * r + c] * camera.T[r];
  }
  PoseJet mean[3], log_scale[3], quaternion[4], dir[3], basis[16], color[3];
  for (int k = 0; k < 3; ++k) {
    mean[k] = PoseJet(scene.At(kMean + k, i)), log_scale[k] = PoseJet(scene.At(kLogScale + k, i));
  }
  for (int k = 0; k < 4; ++k) quaternion[k] = PoseJet(scene.At(kQuaternion + k, i));
  ProjectionState<Pinhole<double>, PoseJet> state;
  const SplatShape<PoseJet> jet = Project(camera, mean, log_scale, quaternion, state);
  ViewDirection(camera.centre, mean, dir);
  ShBasis<3>(dir[0], dir[1], dir[2], basis);
  ShColor<3>(
      basis, [&](int a) { return PoseJet(scene.At(kSh + a, i)); }, color);
  for (int k = 0; k < kPoseTangent; ++k) {
    double w[kSplatTangent] = {};
    TangentOf(
        jet, [k](const PoseJet& x) { return x.v[k]; }, w);
    for (int c = 0; c < 3; ++c) w[kColor + c] = color[c].a > 0 ? color[c].v[k] : 0;
    for (int row = 0; row < kSplatTangent; ++row) K[row][k] = w[row];
  }
}

PoseTangent Unit(int k) {
  PoseTangent xi;
  xi.v[k] = 1;
  return xi;
}

// The axes of a zero quaternion are the world axes, which also rotate with the camera.
TEST(PoseOfASplat, TangentAgreesWithJetsOfTheMovedCamera) {
  Scene scene = test::RandomScene(SceneOptions{}, 80);
  for (int k = 0; k < 4; ++k) scene.At(kQuaternion + k, 3) = 0;
  RenderedView<double> rendered(scene);
  const std::int32_t* rank_of = rendered.view.rank_of().data();
  ASSERT_GE(rank_of[3], 0);
  const CameraKernels<double>& kernels = GetCameraKernels<double>(3);
  std::vector<SplatTangent<double>> tangents[kPoseTangent];
  for (int k = 0; k < kPoseTangent; ++k) {
    tangents[k].resize(static_cast<std::size_t>(rendered.num_splats()));
    kernels.tangent(rendered.model, scene.view, Unit(k), 0, scene.count, rank_of, tangents[k].data());
  }
  for (int i = 0; i < scene.count; ++i) {
    if (rank_of[i] < 0) continue;
    double K[kSplatTangent][kPoseTangent];
    PoseJetRows(scene, i, K);
    for (int row = 0; row < kSplatTangent; ++row) {
      const double scale = 1e-3 + std::abs(*std::max_element(K[row], K[row] + kPoseTangent, [](double a, double b) {
                             return std::abs(a) < std::abs(b);
                           }));
      for (int k = 0; k < kPoseTangent; ++k) {
        EXPECT_NEAR(tangents[k][static_cast<std::size_t>(rank_of[i])].w[row], K[row][k], 1e-9 * scale)
            << "Gaussian " << i << ", row " << row << ", pose number " << k;
      }
    }
  }
}

class PoseJacobian : public testing::TestWithParam<SceneOptions> {};
INSTANTIATE_TEST_SUITE_P(Scenes, PoseJacobian, testing::ValuesIn(test::SceneKinds()),
                         [](const auto& param) { return param.param.name; });

// Central differences, away from decisions.
TEST_P(PoseJacobian, IsTheDerivativeOfTheImage) {
  const Scene scene = test::RandomScene(GetParam(), 81);
  RenderedView<double> rendered(scene);
  for (int k = 0; k < kPoseTangent; ++k) {
    SCOPED_TRACE(k);
    std::vector<double> d_image(rendered.image.size());
    ApplyPoseJ(rendered.view, rendered.model, Unit(k), d_image.data(), rendered.workspace);
    const auto changed = [&](double step) {
      Scene moved = scene;
      PoseTangent xi;
      xi.v[k] = step;
      moved.view = Moved(scene.view, Compose(xi, {}));
      return moved;
    };
    test::ExpectDerivativeOfImage(scene, changed, d_image);
  }
}

template <class S>
void CheckAdjointness(const Scene& scene, double tolerance) {
  RenderedView<S> rendered(scene);
  test::Random random(82);
  const std::vector<S> u = random.NormalVector<S>(rendered.image.size());
  const PoseTangent pose_bar =
      ApplyPoseJT(rendered.view, rendered.model, rendered.image.data(), u.data(), rendered.workspace);
  std::vector<S> jv(u.size());
  for (int k = 0; k < kPoseTangent; ++k) {
    ApplyPoseJ(rendered.view, rendered.model, Unit(k), jv.data(), rendered.workspace);
    EXPECT_LE(test::AdjointGap(u, jv, {static_cast<S>(pose_bar.v[k])}, {S(1)}), tolerance) << k;
  }
}

// One raster pass computes the sum.
TEST_P(PoseJacobian, OfParametersAndPoseIsTheSum) {
  const Scene scene = test::RandomScene(GetParam(), 89);
  RenderedView<double> rendered(scene);
  test::Random random(90);
  const std::vector<double> dx = random.NormalVector<double>(scene.x.size());
  PoseTangent xi;
  for (double& value : xi.v) value = random.Normal();
  std::vector<double> of_model(rendered.image.size()), of_pose(of_model.size()), both(of_model.size()),
      one(of_model.size());
  rendered.view.ApplyJ(rendered.model, dx.data(), of_model.data(), rendered.workspace);
  ApplyPoseJ(rendered.view, rendered.model, xi, of_pose.data(), rendered.workspace);
  ApplyModelAndPoseJ(rendered.view, rendered.model, dx.data(), &xi, both.data(), rendered.workspace);
  ApplyModelAndPoseJ<double>(rendered.view, rendered.model, dx.data(), nullptr, one.data(), rendered.workspace);
  double scale = 0;
  for (std::size_t i = 0; i < both.size(); ++i) {
    scale = std::max({scale, std::abs(of_model[i]), std::abs(of_pose[i])});
  }
  for (std::size_t i = 0; i < both.size(); ++i) {
    ASSERT_NEAR(one[i], of_model[i], 1e-11 * scale) << i;
    ASSERT_NEAR(both[i], of_model[i] + of_pose[i], 1e-11 * scale) << i;
  }
}

// Behind opaque Gaussians the adjoint is a small difference of images (jacobian_test.cpp).
TEST_P(PoseJacobian, ProductsAreAdjoint) {
  const Scene scene = test::RandomScene(GetParam(), 83);
  CheckAdjointness<double>(scene, GetParam().extreme ? 1e-6 : 1e-12);
  if (!GetParam().extreme) CheckAdjointness<float>(scene, 1e-4);
}

// Every instruction set of this CPU agrees with the double reference.
TEST_P(PoseJacobian, InstructionSetsAgree) {
  const Scene scene = test::RandomScene(GetParam(), 84);
  RenderedView<double> exact(scene);
  RenderedView<float> rendered(scene);
  const std::int32_t* rank_of = exact.view.rank_of().data();
  const auto splats = static_cast<std::size_t>(exact.num_splats());
  test::Random random(85);
  PoseTangent xi;
  for (double& value : xi.v) value = random.Normal();
  std::vector<SplatTangent<double>> tangents(splats), cotangents(splats);
  std::vector<SplatTangent<float>> float_tangents(splats), float_cotangents(splats);
  for (std::size_t i = 0; i < splats; ++i) {
    for (int k = 0; k < kSplatTangent; ++k) {
      float_cotangents[i].w[k] = static_cast<float>(random.Normal());
      cotangents[i].w[k] = static_cast<double>(float_cotangents[i].w[k]);
    }
  }
  const auto& reference = GetCameraKernels<double>(scene.active_sh_degree);
  reference.tangent(exact.model, scene.view, xi, 0, scene.count, rank_of, tangents.data());
  const PoseTangent expected = reference.adjoint(exact.model, scene.view, 0, scene.count, rank_of, cotangents.data());
  double largest = 0, largest_sum = 0;
  for (const auto& tangent : tangents) {
    for (const double w : tangent.w) largest = std::max(largest, std::abs(w));
  }
  for (const double sum : expected.v) largest_sum = std::max(largest_sum, std::abs(sum));
  for (const Isa isa : test::CpuIsas()) {
    SCOPED_TRACE(IsaName(isa));
    const auto& kernels = FloatCameraKernelsFor(isa, scene.active_sh_degree);
    kernels.tangent(rendered.model, scene.view, xi, 0, scene.count, rank_of, float_tangents.data());
    for (std::size_t i = 0; i < splats; ++i) {
      for (int k = 0; k < kSplatTangent; ++k) EXPECT_NEAR(float_tangents[i].w[k], tangents[i].w[k], 1e-4 * largest);
    }
    const PoseTangent sums =
        kernels.adjoint(rendered.model, scene.view, 0, scene.count, rank_of, float_cotangents.data());
    for (int k = 0; k < kPoseTangent; ++k) EXPECT_NEAR(sums.v[k], expected.v[k], 1e-4 * largest_sum) << k;
  }
}

// Every active degree of three bands.
TEST(PoseJacobianDegrees, ProductsAreAdjoint) {
  for (int active = 0; active <= 3; ++active) {
    SCOPED_TRACE(active);
    Scene scene = test::RandomScene(SceneOptions{}, 86);
    scene.active_sh_degree = active;
    CheckAdjointness<double>(scene, 1e-12);
  }
}

template <class S>
void CheckThreads() {
  SceneOptions options;
  options.width = 90, options.height = 70, options.count = 4000, options.sh_degree = 1;
  options.sigma_min = 0.5, options.sigma_max = 4;
  RenderedView<S> rendered(test::RandomScene(options, 87));
  test::Random random(88);
  const std::vector<S> u = random.NormalVector<S>(rendered.image.size());
  test::ExpectSameForAnyThreads([&] {
    std::vector<S> d_image(u.size());
    ApplyPoseJ(rendered.view, rendered.model, Unit(1), d_image.data(), rendered.workspace);
    const PoseTangent sums =
        ApplyPoseJT(rendered.view, rendered.model, rendered.image.data(), u.data(), rendered.workspace);
    return std::pair(d_image, std::vector<double>(sums.v, sums.v + kPoseTangent));
  });
}

TEST(PoseJacobianThreads, BitIdenticalForAnyNumber) {
  CheckThreads<float>();
  CheckThreads<double>();
}

}  // namespace
}  // namespace vesta::splat
