// SPDX-License-Identifier: Apache-2.0
// Separable coded apertures: point spread functions of 25 x 25 pixels that are the product of a column and a row of
// transmissions, as in mask-based cameras (Asif et al., FlatCam: thin, lensless cameras using coded aperture and
// computation, 2017). Unlike a lens out of focus, a pseudo-random code keeps every spatial frequency; several codes
// together keep all of them well.
#pragma once

#include <array>
#include <vector>

#include "kernels/core/span.h"

namespace vesta::deconvolution {

inline constexpr int kTaps = 25;
// Pixels by which a blurred image is wider and higher than what was blurred: all light is caught.
inline constexpr int kSpill = kTaps - 1;

using Code = std::array<double, kTaps>;

// Light from pixel (i, j) falls on (i + p, j + q) in the proportion column[p] * row[q]; both sum to 1, all are > 0.
struct Aperture {
  Code column, row;
};

// Codes chosen among random ones to suit three frames; any number of frames >= 1 is possible. Throws Error otherwise.
std::vector<Aperture> CodedApertures(int frames);

// Eigenvalues of sum_f A_f^T A_f lie within [least, greatest], A_f the blur by aperture f of images of any size: the
// operator is a section of a convolution, whose symbol is sum_f |column_f(w1)|^2 |row_f(w2)|^2. Least is the smallest
// value on a grid of 256 x 256 frequencies, ten for each ripple of the symbol: true to a few percent. Greatest is the
// number of frames, exactly.
struct SymbolRange {
  double least, greatest;
};
SymbolRange NormalSymbol(const std::vector<Aperture>& apertures);

}  // namespace vesta::deconvolution
