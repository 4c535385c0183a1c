// SPDX-License-Identifier: Apache-2.0
// An image recovered from photon counts behind coded apertures: a matrix-free problem whose Jacobian has 625 entries a
// row, and at 2048 x 2048 pixels and three frames would take 88 GiB to store.
//
// The unknowns are x_k = log of the light of pixel k, so the image stays positive: s = exp(x). Frame f expects
// y = A_f s counts and has seen b. The residual is the difference of Anscombe's transforms,
//   r = 2 sqrt(y + 3/8) - 2 sqrt(b + 3/8),
// of unit variance where the counts are Poisson's (Anscombe, The transformation of Poisson, binomial and
// negative-binomial data, 1948). Hence J_f = diag(1 / sqrt(y + 3/8)) A_f diag(s).
#pragma once

#include <memory>

#include "bench/deconvolution/coded_blur.h"
#include "solver/lm_options.h"
#include "solver/problem.h"

namespace vesta::deconvolution {

class PhotonImage final : public Problem<CpuBackend<double>> {
 public:
  // counts: num_frames() frames of (side + kSpill)^2 values >= 0, one after the other. Throws Error on other sizes.
  PhotonImage(Index side, std::vector<Aperture> apertures, HostBuffer<double> counts);

  const CodedBlur& blur() const { return blur_; }
  Index num_residuals() const { return counts_.size(); }
  // Entries of J that are not zero for structural reasons: every pixel lights kTaps^2 pixels of each frame.
  Index jacobian_entries() const { return blur_.num_frames() * blur_.image_size() * kTaps * kTaps; }
  // Bytes of J in compressed rows: a double and a 32-bit column an entry, a 32-bit offset a row, as in Ceres.
  double stored_jacobian_bytes() const;

  // A start: x of the uniform image that emits as much light in all as was counted.
  double UniformStart() const;

  Index num_parameters() const override { return blur_.image_size(); }
  double Cost(ConstVectorView x) override;
  std::unique_ptr<Linearization<CpuBackend<double>>> Linearize(ConstVectorView x) override;

 private:
  class AtX;

  CodedBlur blur_;
  HostBuffer<double> counts_;
  HostBuffer<double> plane_;  // one frame
};

// Options that find the light of every pixel to 1e-6 of itself where the counts are free of noise: conjugate gradients,
// so no Jacobian, and no stop by the change of the cost.
LmOptions PhotonImageOptions();

// Expected counts of an image of light s >= 0: the frames, one after the other.
HostBuffer<double> Expose(Index side, const std::vector<Aperture>& apertures, HostSpan<const double> image);

// A made-up scene of side x side pixels, light between 20 and 400 counts: a slope, discs, gratings of every direction
// and points.
HostBuffer<double> TestScene(Index side);

}  // namespace vesta::deconvolution
