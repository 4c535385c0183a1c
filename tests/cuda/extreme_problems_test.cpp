// SPDX-License-Identifier: Apache-2.0
// Extreme images and cameras on the device, with the host's checks.
#include "problems/gaussian_splatting/model/device_splat_backend.h"
#include "tests/cuda/on_device.h"
#include "tests/problems/gaussian_splatting/lm/extreme_problem.h"

namespace vesta::gs::test {
namespace {

class CudaExtremeProblems : public vesta::test::OnDevice {};

TEST_F(CudaExtremeProblems, Operators) {
  for (const ExtremeProblem& c : kExtremeProblems) {
    SCOPED_TRACE(c.name);
    CheckOperators<CudaBackend<float>>(c);
  }
}

TEST_F(CudaExtremeProblems, Solves) {
  for (const ExtremeProblem& c : kExtremeProblems) {
    SCOPED_TRACE(c.name);
    CheckSolves<CudaBackend<float>>(c, {JacobianKind::kCache16});
  }
}

}  // namespace
}  // namespace vesta::gs::test
