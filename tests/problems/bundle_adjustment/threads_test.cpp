// SPDX-License-Identifier: Apache-2.0
// Results are bit-identical for any number of threads.
#include <gtest/gtest.h>

#include "problems/bundle_adjustment/bundle_problem.h"
#include "solver/derivative_check.h"
#include "solver/reduced_system.h"
#include "tests/problems/bundle_adjustment/small_problem.h"
#include "tests/support/any_threads.h"
#include "tests/support/linearize_at.h"

namespace vesta::bundle {
namespace {

// All results that a solve uses.
std::vector<double> Everything(JacobianStorage storage, ReducedForm form) {
  // Several chunks of points, slices per camera, and chunks of rows.
  const BundleData data = Generate({.num_cameras = 70, .num_points = 3000, .mean_track = 5});
  BundleProblem problem(data, {.storage = storage, .reduced_form = form});
  const Cpu::Vector x = Start(data);
  Cpu backend;
  std::vector<double> all(data.x.begin(), data.x.end());
  const auto add = [&](Cpu::ConstVectorView v) { all.insert(all.end(), v.begin(), v.end()); };
  all.push_back(problem.Cost(x));
  const auto linearization = LinearizeAt(problem, x);
  Cpu::Vector v(problem.num_parameters()), w(v.size()), u(linearization->num_residuals()), metric(v.size());
  FillRandom(backend, 8, v.view());
  add(linearization->residuals());
  linearization->Gradient(w);
  add(w);
  linearization->ApplyJ(v, u);
  add(u);
  linearization->ApplyJT(u, w);
  add(w);
  linearization->ApplyH(v, w);
  add(w);
  linearization->DiagJTJ(metric);
  add(metric);
  const auto reduced = linearization->MakeReducedSystem();
  const Index kept = reduced->size();
  Cpu::Vector y(kept);
  reduced->SetDamping(1e-3, metric);
  reduced->ReduceRhs(v, y);
  add(y);
  reduced->Apply(v.view().subspan(0, kept), y);
  add(y);
  BlockDiagonal<Cpu> blocks(kept, reduced->kept_groups());
  reduced->DiagonalBlocks(blocks);
  add(blocks.all_values());
  if (LinearOperator<Cpu>* factor = reduced->Factorize()) {
    factor->Apply(v.view().subspan(0, kept), y);
    add(y);
  }
  reduced->BackSubstitute(v, w);
  add(w);
  return all;
}

TEST(BundleThreads, SameBits) {
  for (const JacobianStorage storage : {JacobianStorage::kDouble, JacobianStorage::kFloat}) {
    for (const ReducedForm form : {ReducedForm::kImplicit, ReducedForm::kExplicit}) {
      vesta::test::ExpectSameForAnyThreads([&] { return Everything(storage, form); });
    }
  }
}

}  // namespace
}  // namespace vesta::bundle
