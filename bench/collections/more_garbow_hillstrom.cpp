// SPDX-License-Identifier: Apache-2.0
#include "bench/collections/more_garbow_hillstrom.h"

#include "bench/collections/more_garbow_hillstrom_models.h"

namespace vesta::mgh {

const std::vector<Formula>& Formulas() {
  static const std::vector<Formula> formulas = [] {
    std::vector<Formula> all;
    ForEachProblem([&]<class F>(int number) {
      Formula formula{number, F::kName, MakeSmallProblem(std::vector<F>(1)), F::kStart, F::kSumOfSquares, {}, {}, 0};
      if constexpr (requires { F::kStationary; }) formula.stationary = F::kStationary;
      if constexpr (Bounded<F>) {
        formula.box = {F::kLower, F::kUpper};
        formula.bounded_sum_of_squares = F::kBoundedSumOfSquares;
      }
      all.push_back(std::move(formula));
    });
    return all;
  }();
  return formulas;
}

}  // namespace vesta::mgh
