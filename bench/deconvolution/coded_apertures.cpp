// SPDX-License-Identifier: Apache-2.0
#include "bench/deconvolution/coded_apertures.h"

#include <cmath>
#include <complex>
#include <limits>
#include <numbers>
#include <numeric>

#include "kernels/core/check.h"
#include "kernels/core/random.h"

namespace vesta::deconvolution {
namespace {

// Of all seeds below 4000, the one whose three frames have the largest minimum of the symbol.
constexpr std::uint64_t kSeed = 1803;

Code RandomCode(Index frame, Index axis) {
  CounterRandom random(kSeed, static_cast<std::uint64_t>(frame), static_cast<std::uint64_t>(axis));
  Code code;
  // A high power makes few openings transmit most of the light; this one has the flattest
  // spectrum of the powers tried.
  for (double& tap : code) tap = 0.02 + 0.98 * std::pow(random.Uniform(), 4.0);
  const double sum = std::accumulate(code.begin(), code.end(), 0.0);
  for (double& tap : code) tap /= sum;
  return code;
}

constexpr int kFrequencies = 256;

std::array<double, kFrequencies> PowerSpectrum(const Code& code) {
  std::array<double, kFrequencies> power{};
  for (int m = 0; m < kFrequencies; ++m) {
    std::complex<double> sum = 0;
    for (int p = 0; p < kTaps; ++p)
      sum += code[static_cast<std::size_t>(p)] * std::polar(1.0, 2 * std::numbers::pi * m * p / kFrequencies);
    power[static_cast<std::size_t>(m)] = std::norm(sum);
  }
  return power;
}

}  // namespace

std::vector<Aperture> CodedApertures(int frames) {
  if (frames < 1) Fail(kBadArgument, "{} frames; choose 1 or more", frames);
  std::vector<Aperture> apertures;
  apertures.reserve(static_cast<std::size_t>(frames));
  for (int f = 0; f < frames; ++f) apertures.push_back({RandomCode(f, 0), RandomCode(f, 1)});
  return apertures;
}

SymbolRange NormalSymbol(const std::vector<Aperture>& apertures) {
  std::vector<std::array<double, kFrequencies>> columns, rows;
  for (const Aperture& aperture : apertures) {
    columns.push_back(PowerSpectrum(aperture.column));
    rows.push_back(PowerSpectrum(aperture.row));
  }
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < kFrequencies; ++i) {
    for (std::size_t j = 0; j < kFrequencies; ++j) {
      double sum = 0;
      for (std::size_t f = 0; f < apertures.size(); ++f) sum += columns[f][i] * rows[f][j];
      least = std::min(least, sum);
    }
  }
  return {least, static_cast<double>(apertures.size())};
}

}  // namespace vesta::deconvolution
