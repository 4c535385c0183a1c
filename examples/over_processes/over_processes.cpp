// SPDX-License-Identifier: Apache-2.0
// Computes the heights of marks from measured height differences of pairs of marks (a levelling network). Runs in
// several processes: mpirun -n 3 over_processes
#include <cmath>
#include <cstdio>
#include <memory>
#include <vector>

#include "kernels/mpi/mpi_communicator.h"
#include "solver/distributed/block_parts.h"
#include "solver/distributed/distributed_problem.h"
#include "solver/levenberg_marquardt.h"

namespace {

constexpr int kMarks = 5000;  // number of marks; only the height of mark 0 is known

double TrueHeight(int mark) { return 100 + 20 * std::sin(0.01 * mark) + 0.1 * (mark % 7); }

// One measurement: the height difference of two marks.
class Levelled final : public vesta::CostFunction {
 public:
  explicit Levelled(double difference) : CostFunction(1, std::vector<int>{1, 1}), difference_(difference) {}
  bool Evaluate(const double* const* heights, double* residual, double** jacobians) const override {
    residual[0] = heights[1][0] - heights[0][0] - difference_;
    if (jacobians != nullptr && jacobians[0] != nullptr) jacobians[0][0] = -1;
    if (jacobians != nullptr && jacobians[1] != nullptr) jacobians[1][0] = 1;
    return true;
  }

 private:
  double difference_;
};

// Each process creates the whole problem, but evaluates only the cost functions of its own parts.
void AddNetwork(vesta::BlockProblem& problem) {
  for (int mark = 0; mark < kMarks; ++mark) problem.AddParameterBlock(1);
  problem.SetConstant(0);
  for (int from = 0; from < kMarks; ++from) {
    for (const int way : {1, 10, 300}) {
      if (from + way >= kMarks) continue;
      const double error = 1e-3 * ((from * 31 + way) % 5 - 2);  // simulated error of up to 2 mm, in metres
      problem.AddResidualBlock(std::make_shared<Levelled>(TrueHeight(from + way) - TrueHeight(from) + error), nullptr,
                               {from, from + way});
    }
  }
}

int Solve(vesta::Communicator& ranks) {
  vesta::BlockProblem network;
  AddNetwork(network);
  std::vector<double> heights(kMarks, TrueHeight(0));

  vesta::BlockParts parts(network, 64);
  vesta::DistributedProblem<vesta::CpuBackend<double>> problem(ranks, parts);
  vesta::CpuBackend<double> backend;
  vesta::LmOptions options;
  options.normal_system.pcg.model_tolerance = 1e-6;
  options.normal_system.pcg.max_iterations = 2000;
  const vesta::LmSummary summary = vesta::SolveLm(options, backend, problem, {heights.data(), kMarks});

  double worst = 0;
  for (int mark = 0; mark < kMarks; ++mark) worst = std::fmax(worst, std::fabs(heights[mark] - TrueHeight(mark)));
  if (ranks.rank() == 0) {
    std::printf("%d processes: %s\n", ranks.size(), summary.BriefReport().c_str());
    std::printf("heights to %.4f m\n", worst);
  }
  return vesta::IsConverged(summary.status) && worst < 0.01 ? 0 : 1;
}

}  // namespace

int main() {
  const std::unique_ptr<vesta::Communicator> ranks = vesta::StartMpi();
  try {
    return Solve(*ranks);
  } catch (const vesta::Error& error) {
    std::fprintf(stderr, "over_processes: %s\n", error.what());
    ranks->Abandon(error.what());  // ends the other processes, which would otherwise wait forever
    return 1;
  }
}
