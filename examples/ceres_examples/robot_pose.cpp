// SPDX-License-Identifier: Apache-2.0
// Most likely positions of a robot in a corridor, from the odometer and the measured distance to the end wall. Each
// distance depends on all moves so far, so the number of parameter blocks differs. Ceres: robot_pose_mle.cc.
#include <cmath>
#include <cstdio>
#include <memory>
#include <numeric>
#include <vector>

#include "solver/block_problem.h"
#include "solver/levenberg_marquardt.h"

constexpr double kCorridor = 30;         // length in metres
constexpr double kOdometerSigma = 0.1;   // of a move
constexpr double kDistanceSigma = 0.01;  // of a distance

// (length of the corridor - sum of the moves - distance) / sigma, with a block of one number per move.
class WallDistance final : public vesta::CostFunction {
 public:
  WallDistance(std::size_t moves, double distance) : CostFunction(1, std::vector<int>(moves, 1)), distance_(distance) {}
  bool Evaluate(const double* const* parameters, double* residuals, double** jacobians) const override {
    double position = 0;
    for (std::size_t k = 0; k < block_sizes().size(); ++k) {
      position += parameters[k][0];
      if (jacobians != nullptr && jacobians[k] != nullptr) jacobians[k][0] = -1 / kDistanceSigma;
    }
    residuals[0] = (kCorridor - position - distance_) / kDistanceSigma;
    return true;
  }

 private:
  double distance_;
};

int main() {
  vesta::BlockProblem problem;
  std::vector<double> truth, moves;  // of the robot, and as the odometer measures them
  std::vector<int> blocks;
  double position = 0;
  for (int i = 0; position < kCorridor - 1; ++i) {
    truth.push_back(0.5);
    position += truth.back();
    moves.push_back(truth.back() + kOdometerSigma * std::sin(5.0 * i * i + 1));
    const double distance = kCorridor - position + kDistanceSigma * std::sin(3.0 * i * i);
    blocks.push_back(problem.AddParameterBlock(1));
    problem.AddResidualBlock(
        std::make_shared<vesta::NormalPrior>(std::vector{1 / kOdometerSigma}, std::vector{moves.back()}), nullptr,
        {blocks.back()});
    problem.AddResidualBlock(std::make_shared<WallDistance>(blocks.size(), distance), nullptr, blocks);
  }
  // Largest error of a position.
  const auto error = [&](const std::vector<double>& estimate) {
    double sum = 0, largest = 0;
    for (std::size_t i = 0; i < truth.size(); ++i) {
      sum += estimate[i] - truth[i];
      largest = std::max(largest, std::abs(sum));
    }
    return largest;
  };
  std::vector<double> x = moves;
  const vesta::LmSummary summary = vesta::SolveLm(problem, x);
  std::puts(summary.BriefReport().c_str());
  std::printf("largest error of a position: odometer %.3f m, estimate %.3f m\n", error(moves), error(x));
  return vesta::IsConverged(summary.status) && error(x) < 2 * kDistanceSigma && error(moves) > error(x) ? 0 : 1;
}
