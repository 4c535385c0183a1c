// SPDX-License-Identifier: Apache-2.0
// Separable coded apertures: point spread functions of 25 x 25 pixels, the product of a column and a row of
// transmissions, as in mask-based cameras (Asif et al., FlatCam: thin, lensless cameras using coded aperture and
// computation, 2017). Defocus removes some spatial frequencies from the image. A pseudo-random code preserves all of
// them, and several codes together preserve them well.
#pragma once

#include <array>
#include <vector>

#include "kernels/core/span.h"

namespace vesta::deconvolution {

inline constexpr int kTaps = 25;  // width and height of the point spread functions, pixels
// A blurred image (frame) is wider and higher than the sharp one by this many pixels, so that it contains all light.
inline constexpr int kSpill = kTaps - 1;

using Code = std::array<double, kTaps>;

// The fraction column[p] * row[q] of the light of pixel (i, j) of the image falls on pixel (i + p, j + q) of the frame.
// All entries are > 0; column and row each sum to 1.
struct Aperture {
  Code column, row;
};

// Random codes, one per frame. The fixed seed was chosen for three frames. Throws Error for frames < 1.
std::vector<Aperture> CodedApertures(int frames);

// Bounds of the eigenvalues of sum_f A_f^T A_f for images of any size, where A_f is the blur by aperture f. The
// operator is a section of a convolution, whose Fourier transform (symbol) is sum_f |column_f(w1)|^2 |row_f(w2)|^2.
// `least` is its minimum on a grid of 256 x 256 frequencies, accurate to a few percent. `greatest` is the number of
// frames.
struct SymbolRange {
  double least, greatest;
};
SymbolRange NormalSymbol(const std::vector<Aperture>& apertures);

}  // namespace vesta::deconvolution
