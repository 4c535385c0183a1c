// SPDX-License-Identifier: Apache-2.0
// Calibration of one camera from views of a flat target: each residual depends on twelve of few parameters.
#include <ceres/rotation.h>

#include <array>
#include <cmath>

#include "bench/solver_race/contenders.h"
#include "bench/solver_race/engines.h"

namespace vesta::bench {
namespace {

constexpr int kIntrinsics = 6;  // focal lengths, principal point, two radial coefficients
constexpr int kColumns = 9;     // columns of corners on the target

// A corner (x, y) of the target, observed at pixel (u, v).
struct Corner {
  double x, y, u, v;

  template <class T>
  bool operator()(const T* intrinsics, const T* pose, T* residuals) const {
    const T on_target[3] = {T(x), T(y), T(0)};
    T p[3];
    ceres::AngleAxisRotatePoint(pose, on_target, p);
    const T px = (p[0] + pose[3]) / (p[2] + pose[5]), py = (p[1] + pose[4]) / (p[2] + pose[5]);
    const T square = px * px + py * py;
    const T radial = 1.0 + square * (intrinsics[4] + square * intrinsics[5]);
    residuals[0] = intrinsics[0] * radial * px + intrinsics[2] - u;
    residuals[1] = intrinsics[1] * radial * py + intrinsics[3] - v;
    return true;
  }
};

struct Calibration {
  std::array<double, kIntrinsics> intrinsics;
  std::vector<std::array<double, 6>> poses;
  std::vector<std::vector<Corner>> corners;  // by view
  // Errors of up to 0.2 pixels, and a guess as the start. Sines replace random numbers.
  Calibration(int views, int corners_each) : intrinsics{800, 800, 320, 240, 0, 0}, corners(Size(views)) {
    const std::array<double, kIntrinsics> truth{870, 860, 331, 236, -0.21, 0.08};
    for (int i = 0; i < views; ++i) {
      const double a = 0.7 * i;
      const std::array<double, 6> pose{0.4 * std::sin(a), 0.4 * std::cos(1.3 * a), 0.2 * std::sin(2.1 * a),
                                       0.2 * std::cos(a), 0.1 * std::sin(1.7 * a), 3 + 0.5 * std::sin(0.9 * a)};
      for (int k = 0; k < corners_each; ++k) {
        const double n = kColumns * corners_each * i + k;
        const int column = k % kColumns, row = k / kColumns;
        Corner corner{0.2 * (column - 4), 0.2 * (row - 3), 0, 0};
        double seen[2];
        corner(truth.data(), pose.data(), seen);
        corner.u = seen[0] + 0.2 * std::sin(12.9898 * n);
        corner.v = seen[1] + 0.2 * std::sin(78.233 * n);
        corners[Size(i)].push_back(corner);
      }
      poses.push_back(pose);
      for (std::size_t c = 0; c < 6; ++c) poses.back()[c] += 0.03 * std::sin(5.0 * i + static_cast<double>(c));
    }
  }
  void Fill(ceres::Problem& problem) {
    for (std::size_t i = 0; i < poses.size(); ++i) {
      for (const Corner& corner : corners[i]) {
        problem.AddResidualBlock(new ceres::AutoDiffCostFunction<Corner, 2, kIntrinsics, 6>(new Corner(corner)),
                                 nullptr, intrinsics.data(), poses[i].data());
      }
    }
  }
  // Eliminates the views first, as Ceres's documentation advises.
  ceres::ParameterBlockOrdering* Ordering() {
    auto* ordering = new ceres::ParameterBlockOrdering;
    for (auto& pose : poses) ordering->AddElementToGroup(pose.data(), 0);
    ordering->AddElementToGroup(intrinsics.data(), 1);
    return ordering;
  }

 private:
  static std::size_t Size(int n) { return static_cast<std::size_t>(n); }
};

}  // namespace

std::vector<Contender> CalibrationContenders(int views, int corners, const RaceOptions& race) {
  std::vector<Contender> contenders;
  const auto bridge = [&](const std::string& name, LinearSolverKind kind) {
    contenders.push_back({name, [=] {
                            Calibration calibration(views, corners);
                            ceres::Problem problem;
                            calibration.Fill(problem);
                            LmOptions lm;
                            lm.normal_system.linear_solver = kind;
                            return SolveByBridge(lm, problem, race);
                          }});
  };
  const auto ceres_solver = [&](const std::string& name, const CeresSolver& solver, bool schur = false) {
    contenders.push_back({name, [=] {
                            Calibration calibration(views, corners);
                            ceres::Problem problem;
                            calibration.Fill(problem);
                            return SolveByCeres(solver, problem, race, schur ? calibration.Ordering() : nullptr);
                          }});
  };
  bridge("vesta bridge auto", LinearSolverKind::kAuto);
  bridge("vesta bridge dense QR", LinearSolverKind::kDenseQr);
  ceres_solver("Ceres CGNR", {ceres::CGNR});
  ceres_solver("Ceres DENSE_QR", {ceres::DENSE_QR});
  ceres_solver("Ceres DENSE_NORMAL_CHOLESKY", {ceres::DENSE_NORMAL_CHOLESKY});
  ceres_solver("Ceres SPARSE_NORMAL_CHOLESKY", {ceres::SPARSE_NORMAL_CHOLESKY});
  ceres_solver("Ceres DENSE_SCHUR", {ceres::DENSE_SCHUR}, true);
  ceres_solver("Ceres SPARSE_SCHUR", {ceres::SPARSE_SCHUR}, true);
  return contenders;
}

}  // namespace vesta::bench
