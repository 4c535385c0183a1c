// SPDX-License-Identifier: Apache-2.0
#include "bench/collections/nist.h"

#include "bench/collections/nist_models.h"

namespace vesta::nist {

const std::vector<Regression>& Regressions() {
  static const std::vector<Regression> regressions = [] {
    std::vector<Regression> all;
    ForEachProblem([&]<class Model>(const Problem& problem) {
      using InFloat = ResidualBlocks<Residual<Model>, CpuBackend<float>>;
      all.push_back({problem, MakeSmallProblem(Residuals<Model>(problem)),
                     [&problem] { return std::make_unique<InFloat>(Model::kParameters, Residuals<Model>(problem)); }});
    });
    return all;
  }();
  return regressions;
}

}  // namespace vesta::nist
