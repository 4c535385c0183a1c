// SPDX-License-Identifier: Apache-2.0
// Estimates the light at each time i from the readings y_i of a slow detector: y_i = a y_(i-1) + exp(x_i) with a = 0.9.
// The unknown x_i is the logarithm of the light. Every reading depends on all earlier times, so a stored Jacobian for a
// million readings would have 5 * 10^11 entries. A product with the Jacobian, however, needs only one pass over the
// data.
#include <cmath>
#include <cstdio>

#include "solver/check_problem.h"
#include "solver/derivative_check.h"
#include "solver/levenberg_marquardt.h"

using Backend = vesta::CpuBackend<double>;
using VectorView = Backend::VectorView;
using ConstVectorView = Backend::ConstVectorView;
using vesta::Index;

constexpr double kMemory = 0.9;  // a

// out_i = a out_(i-1) + light_i.
void Detect(ConstVectorView light, VectorView out) {
  double reading = 0;
  for (Index i = 0; i < light.size(); ++i) out[i] = reading = kMemory * reading + light[i];
}

// J = A diag(exp(x)), where A is the matrix of the linear function Detect.
class DetectorLinearization final : public vesta::Linearization<Backend> {
 public:
  DetectorLinearization(ConstVectorView x, ConstVectorView readings)
      : light_(x.size()), work_(x.size()), residuals_(x.size()) {
    for (Index i = 0; i < x.size(); ++i) light_[i] = std::exp(x[i]);
    Detect(light_, residuals_);
    for (Index i = 0; i < x.size(); ++i) residuals_[i] -= readings[i];
  }
  Index num_residuals() const override { return light_.size(); }
  Index num_parameters() const override { return light_.size(); }
  ConstVectorView residuals() const override { return residuals_; }
  void ApplyJ(ConstVectorView v, VectorView u) override {
    for (Index i = 0; i < v.size(); ++i) work_[i] = light_[i] * v[i];
    Detect(work_, u);
  }
  // The transpose of a filter that runs forwards is the same filter, run backwards.
  void ApplyJT(ConstVectorView u, VectorView g) override {
    double sum = 0;
    for (Index i = u.size() - 1; i >= 0; --i) {
      sum = kMemory * sum + u[i];
      g[i] = light_[i] * sum;
    }
  }
  // Column i of J has the entries exp(x_i) (1, a, a^2, ...) from row i on, and zeros above.
  void DiagJTJ(VectorView d) override {
    double sum = 0;
    for (Index i = d.size() - 1; i >= 0; --i) {
      sum = kMemory * kMemory * sum + 1;
      d[i] = light_[i] * light_[i] * sum;
    }
  }

 private:
  Backend::Vector light_, work_, residuals_;
};

class DetectorProblem final : public vesta::Problem<Backend> {
 public:
  explicit DetectorProblem(Backend::Vector readings) : readings_(std::move(readings)) {}
  Index num_parameters() const override { return readings_.size(); }
  double Cost(ConstVectorView x) override {
    double cost = 0, reading = 0;
    for (Index i = 0; i < x.size(); ++i) {
      reading = kMemory * reading + std::exp(x[i]);
      cost += 0.5 * (reading - readings_[i]) * (reading - readings_[i]);
    }
    return cost;
  }
  std::unique_ptr<vesta::Linearization<Backend>> Linearize(ConstVectorView x) override {
    return std::make_unique<DetectorLinearization>(x, readings_);
  }

 private:
  Backend::Vector readings_;
};

Backend::Vector TrueLight(Index size) {
  Backend::Vector x(size);
  for (Index i = 0; i < size; ++i)
    x[i] = std::sin(0.1 * static_cast<double>(i)) + std::sin(0.001 * static_cast<double>(i));
  return x;
}

DetectorProblem MakeProblem(Index size) {
  Backend::Vector light = TrueLight(size), readings(size);
  for (double& value : light) value = std::exp(value);
  Detect(light, readings);
  return DetectorProblem(std::move(readings));
}

// Checks that the operators match the cost, on a problem so small that every column can be tested.
bool Check() {
  Backend backend;
  DetectorProblem problem = MakeProblem(50);
  Backend::Vector x(50);
  vesta::FillRandom(backend, 1, x.view());
  const vesta::ProblemCheck check = vesta::CheckProblem(backend, problem, x);
  std::puts(check.Report().c_str());
  return check.ok();
}

int main() {
  if (!Check()) return 1;
  const Index size = 1'000'000;
  DetectorProblem problem = MakeProblem(size);
  Backend backend;
  Backend::Vector x(size);
  vesta::LmOptions options;
  options.normal_system.pcg.model_tolerance = 0.01;
  options.function_tolerance = 1e-9;
  const vesta::LmSummary summary = vesta::SolveLm(options, backend, problem, x.view());
  std::puts(summary.FullReport().c_str());

  const Backend::Vector truth = TrueLight(size);
  double error = 0;
  for (Index i = 0; i < size; ++i) error = std::max(error, std::abs(x[i] - truth[i]));
  std::printf("largest error: %.1e\n", error);
  return vesta::IsConverged(summary.status) && error < 1e-3 ? 0 : 1;
}
