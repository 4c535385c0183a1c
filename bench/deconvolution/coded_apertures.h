// SPDX-License-Identifier: Apache-2.0
// Separable coded apertures: point spread functions of 25 x 25 pixels that are the product of a column and a row of
// transmissions, as in mask-based cameras (Asif et al., FlatCam: thin, lensless cameras using coded aperture and
// computation, 2017). Unlike a defocused lens, a pseudo-random code preserves every spatial frequency, and several
// codes together preserve all of them well.
#pragma once

#include <array>
#include <vector>

#include "kernels/core/span.h"

namespace vesta::deconvolution {

inline constexpr int kTaps = 25;
// Pixels by which a blurred image is wider and higher than the sharp one, so that no light is lost.
inline constexpr int kSpill = kTaps - 1;

using Code = std::array<double, kTaps>;

// Light from pixel (i, j) falls on (i + p, j + q) in the proportion column[p] * row[q]; both sum to 1, all are > 0.
struct Aperture {
  Code column, row;
};

// Random codes, with a seed that is optimal for three frames. Throws Error unless frames >= 1.
std::vector<Aperture> CodedApertures(int frames);

// Range of the eigenvalues of sum_f A_f^T A_f, where A_f blurs images of any size by aperture f. The operator is a
// section of a convolution with the symbol sum_f |column_f(w1)|^2 |row_f(w2)|^2. `least` is its minimum on a grid of
// 256 x 256 frequencies, ten for each ripple of the symbol, and is accurate to a few percent. `greatest` is exactly the
// number of frames.
struct SymbolRange {
  double least, greatest;
};
SymbolRange NormalSymbol(const std::vector<Aperture>& apertures);

}  // namespace vesta::deconvolution
