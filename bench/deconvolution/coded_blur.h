// SPDX-License-Identifier: Apache-2.0
// Matrix-free blur of a square image by coded apertures, and its adjoint.
#pragma once

#include <vector>

#include "bench/deconvolution/coded_apertures.h"
#include "bench/deconvolution/separable_correlation.h"
#include "kernels/core/buffer.h"

namespace vesta::deconvolution {

// A_f blurs an image by aperture f = 0, 1, .... Images have side x side values, frames (blurred images) (side + kSpill)
// x (side + kSpill) values, row by row. Not thread-safe.
class CodedBlur {
 public:
  // Throws Error unless side >= 1.
  CodedBlur(Index side, std::vector<Aperture> apertures);

  Index side() const { return side_; }
  Index frame_side() const { return side_ + kSpill; }
  Index image_size() const { return side_ * side_; }
  Index frame_size() const { return frame_side() * frame_side(); }
  int num_frames() const { return static_cast<int>(apertures_.size()); }
  const std::vector<Aperture>& apertures() const { return apertures_; }

  // Sets the image for Blur: pixel k becomes value(k).
  template <class Value>
  void SetImage(const Value& value);
  // out = A_f image, frame_size() entries.
  void Blur(int frame, HostSpan<double> out);

  // Sets the frame for AddAdjoint and AddSquaredAdjoint: pixel i becomes value(i).
  template <class Value>
  void SetFrame(const Value& value);
  // out += A_f^T frame, image_size() entries; with `first`, out = A_f^T frame.
  void AddAdjoint(int frame, bool first, HostSpan<double> out) {
    Accumulate(apertures_[static_cast<std::size_t>(frame)], first, out);
  }
  // The same with the squared entries of A_f; a frame of ones gives the squared column norms of A_f.
  void AddSquaredAdjoint(int frame, bool first, HostSpan<double> out) {
    Accumulate(squared_[static_cast<std::size_t>(frame)], first, out);
  }

 private:
  void Accumulate(const Aperture& aperture, bool first, HostSpan<double> out) const;
  void Correlate(CorrelationArgs args, const Aperture& aperture, Index rows) const;

  Index side_;
  std::vector<Aperture> apertures_, turned_, squared_;
  CorrelateRows correlate_rows_;
  HostBuffer<double> padded_image_;  // the image with kSpill zeros on every side
  HostBuffer<double> frame_;
};

}  // namespace vesta::deconvolution

#include "bench/deconvolution/coded_blur.inl"
