// SPDX-License-Identifier: Apache-2.0
// Recovers an image from photon counts behind coded apertures (coded_apertures.h). The Jacobian J is never stored: with
// 625 entries per row it would take 88 GiB for 2048 x 2048 pixels and three frames.
//
// The unknowns are x_k, the logarithm of the light of pixel k, so the image s = exp(x) is positive. Frame f has the
// expected counts y = A_f s, where A_f is the blur by aperture f, and the measured counts b. The residual is the
// difference of Anscombe's transforms,
//   r = 2 sqrt(y + 3/8) - 2 sqrt(b + 3/8),
// which has unit variance for Poisson counts (Anscombe, The transformation of Poisson, binomial and
// negative-binomial data, 1948). Hence J_f = diag(1 / sqrt(y + 3/8)) A_f diag(s).
#pragma once

#include <memory>

#include "bench/deconvolution/coded_blur.h"
#include "solver/lm_options.h"
#include "solver/problem.h"

namespace vesta::deconvolution {

class PhotonImage final : public Problem<CpuBackend<double>> {
 public:
  // The image has side x side pixels. counts: one frame per aperture, concatenated, each with (side + kSpill)^2 values
  // >= 0. Throws Error for another number of counts.
  PhotonImage(Index side, std::vector<Aperture> apertures, HostBuffer<double> counts);

  const CodedBlur& blur() const { return blur_; }
  Index num_residuals() const { return counts_.size(); }
  // Entries of J that can be nonzero: the light of a pixel falls on kTaps^2 pixels of each frame.
  Index jacobian_entries() const { return blur_.num_frames() * blur_.image_size() * kTaps * kTaps; }
  // Bytes of J in compressed-row storage: a double and a 32-bit column per entry, a 32-bit offset per row, as in Ceres.
  double stored_jacobian_bytes() const;

  // Start for all x_k: a uniform image whose total light equals the total counts.
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

// Options that recover every pixel from counts without noise, to a relative error of 1e-6: PCG and no function
// tolerance.
LmOptions PhotonImageOptions();

// The expected counts of all frames, concatenated, for an image with light s >= 0.
HostBuffer<double> Expose(Index side, const std::vector<Aperture>& apertures, HostSpan<const double> image);

// A synthetic image of side x side pixels with 20 to 400 counts each: a ramp, discs, gratings of all directions, and
// points.
HostBuffer<double> TestScene(Index side);

}  // namespace vesta::deconvolution
