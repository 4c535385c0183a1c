// SPDX-License-Identifier: Apache-2.0
// The 27 nonlinear regression problems of NIST's Statistical Reference Datasets (itl.nist.gov/div898/strd, public
// domain), with certified solutions. nist/ has the observations, nist_models.h the models.
#pragma once

#include <algorithm>
#include <cmath>
#include <span>

namespace vesta::nist {

// According to NIST.
enum class Difficulty { kLower, kAverage, kHigher };

struct Problem {
  const char* name;
  Difficulty difficulty;
  int num_predictors;
  std::span<const double> rows;            // response y, then predictors x1, x2, ...
  std::span<const double> start1, start2;  // NIST's
  std::span<const double> certified;       // parameters
  std::span<const double> deviation;       // certified, of the parameters
  double residual_sum_of_squares;          // certified
};

// Digits, 0..11, in which all parameters agree with the certified ones. NIST lists 11.
inline double Digits(std::span<const double> x, std::span<const double> certified) {
  double digits = 11;
  for (std::size_t k = 0; k < x.size(); ++k) {
    const double error = std::abs(x[k] - certified[k]) / std::abs(certified[k]);
    if (!(error < 1)) return 0;
    if (error > 0) digits = std::min(digits, -std::log10(error));
  }
  return digits;
}

extern const Problem kBennett5, kBoxBOD, kChwirut1, kChwirut2, kDanWood, kENSO, kEckerle4, kGauss1, kGauss2, kGauss3,
    kHahn1, kKirby2, kLanczos1, kLanczos2, kLanczos3, kMGH09, kMGH10, kMGH17, kMisra1a, kMisra1b, kMisra1c, kMisra1d,
    kNelson, kRat42, kRat43, kRoszman1, kThurber;

}  // namespace vesta::nist
