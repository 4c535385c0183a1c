// SPDX-License-Identifier: Apache-2.0
// Operators of the photometric loss on a GPU, as block kernels (kernels/core/block_kernel.h). A field is an array with
// one value per pixel and colour channel. Each block of threads processes 32 x 16 pixels of one channel. It loads the
// fields of an operator at these pixels and in a border of five pixels, blurs the fields with the SSIM window, and
// passes the result to the operator. The formulas and symbols (e, p, q, s, the blur G) are in photometric_formula.h.
// Products of fields are elementwise.
#pragma once

#include "kernels/core/block_kernel.h"
#include "kernels/image/gaussian_window.h"
#include "kernels/image/image_shape.h"
#include "kernels/image/photometric_formula.h"
#include "kernels/image/pixel_penalty.h"

namespace vesta {

inline namespace VESTA_ISA {

// Weights of one axis of the SSIM window (gaussian_window.h), in scalar type S.
template <class S>
struct WindowTaps {
  S tap[kWindowTaps];
};
template <class S>
inline WindowTaps<S> MakeWindowTaps() {
  WindowTaps<S> taps;
  int k = 0;
  for (const double tap : GaussianTaps()) taps.tap[k++] = static_cast<S>(tap);
  return taps;
}
// Values of N fields at one pixel.
template <int N, class S>
struct PixelFields {
  S f[N];
};

// Blurs the fields of an Operator with these members:
//
//   kFields, kSums
//   Load(i) -> PixelFields<kFields>      returns the fields before the blur, at index i of the image
//   Store(i, blurred, sums)              processes the blurred fields, and adds the terms of the pixel to kSums sums
//
// partial_sums: the kSums sums of each block of threads.
template <class S, class Operator>
struct BlurBlock {
  static constexpr int kThreads = 256, kWidth = 32, kHeight = 16;
  static constexpr int kFields = Operator::kFields, kSums = Operator::kSums;
  static constexpr int kPaddedWidth = kWidth + 2 * kWindowRadius, kPaddedHeight = kHeight + 2 * kWindowRadius;
  struct Shared {
    union {
      S field[kFields][kPaddedHeight][kPaddedWidth];
      double lanes[kThreads];  // for the reductions; used after the last use of the fields
    };
    S column[kFields][kHeight][kPaddedWidth];  // blurred along the columns
  };
  int width, height;
  WindowTaps<S> taps;
  Operator op;
  double* partial_sums;

  static constexpr Index NumBlocks(int width, int height) {
    return ImageShape::kChannels * BlocksAcross(width) * BlocksDown(height);
  }

  template <class Block>
  VESTA_HD void operator()(Block& block, Shared& shared) const {
    const Index across = BlocksAcross(width), in_plane = across * BlocksDown(height);
    const Index plane = block.id() / in_plane * (static_cast<Index>(width) * height), piece = block.id() % in_plane;
    const int left = static_cast<int>(piece % across) * kWidth, top = static_cast<int>(piece / across) * kHeight;
    const int thread = block.thread();
    for (int k = thread; k < kPaddedHeight * kPaddedWidth; k += kThreads) {
      const int r = k / kPaddedWidth, c = k % kPaddedWidth, y = top + r - kWindowRadius, x = left + c - kWindowRadius;
      PixelFields<kFields, S> value = {};
      if (x >= 0 && x < width && y >= 0 && y < height) value = op.Load(plane + static_cast<Index>(y) * width + x);
      for (int n = 0; n < kFields; ++n) shared.field[n][r][c] = value.f[n];
    }
    block.Sync();
    for (int k = thread; k < kHeight * kPaddedWidth; k += kThreads) {
      const int r = k / kPaddedWidth, c = k % kPaddedWidth;
      for (int n = 0; n < kFields; ++n) {
        S sum(0);
        for (int t = 0; t < kWindowTaps; ++t) sum = Fma(taps.tap[t], shared.field[n][r + t][c], sum);
        shared.column[n][r][c] = sum;
      }
    }
    block.Sync();
    double sums[kSums > 0 ? kSums : 1] = {};
    for (int k = thread; k < kHeight * kWidth; k += kThreads) {
      const int r = k / kWidth, c = k % kWidth, y = top + r, x = left + c;
      if (x >= width || y >= height) continue;
      PixelFields<kFields, S> blurred;
      for (int n = 0; n < kFields; ++n) {
        S sum(0);
        for (int t = 0; t < kWindowTaps; ++t) sum = Fma(taps.tap[t], shared.column[n][r][c + t], sum);
        blurred.f[n] = sum;
      }
      op.Store(plane + static_cast<Index>(y) * width + x, blurred, sums);
    }
    for (int i = 0; i < kSums; ++i) {
      const double sum = ReduceBlock<kThreads>(block, shared.lanes, sums[i], AddUp{});
      if (thread == 0) partial_sums[block.id() * kSums + i] = sum;
    }
  }

 private:
  VESTA_HD static constexpr Index BlocksAcross(int width) { return (width + kWidth - 1) / kWidth; }
  VESTA_HD static constexpr Index BlocksDown(int height) { return (height + kHeight - 1) / kHeight; }
};

// sums[i] = the sum of partial_sums[kSums * block + i] over all blocks. One block of threads computes one sum.
template <int kSums>
struct SumPartials {
  static constexpr int kThreads = 256;
  struct Shared {
    double lanes[kThreads];
  };
  const double* partial_sums;
  Index blocks;
  double* sums;

  template <class Block>
  VESTA_HD void operator()(Block& block, Shared& shared) const {
    double sum = 0;
    for (Index b = block.thread(); b < blocks; b += kThreads) sum += partial_sums[b * kSums + block.id()];
    sum = ReduceBlock<kThreads>(block, shared.lanes, sum, AddUp{});
    if (block.thread() == 0) sums[block.id()] = sum;
  }
};

// Adds a pixel's |e|, its penalty and its 1 - SSIM to the three sums of the loss.
template <class S>
VESTA_HD inline void AddLoss(const PixelPenalty<S>& pixel, const S& dissimilarity, double* sums) {
  sums[0] += static_cast<double>(pixel.absolute);
  sums[1] += static_cast<double>(pixel.value);
  sums[2] += static_cast<double>(dissimilarity);
}

// Computes the sums of |e|, of the pixel penalty and of 1 - SSIM. Optionally stores the slopes p, q, s of 1 - SSIM
// (SsimSlopes) and the window curvature (SsimWindowCurvature).
template <class S>
struct LossSumsOperator {
  static constexpr int kFields = 4, kSums = 3;
  const S *rendered, *truth;
  PenaltyCoefficients<S> penalty;
  // Outputs. curvature may be null; or all four are null.
  S *p, *q, *s, *curvature;

  VESTA_HD PixelFields<4, S> Load(Index i) const {
    const S u = rendered[i] + truth[i], e = rendered[i] - truth[i];
    return {{u, e, u * u, e * e}};
  }
  VESTA_HD void Store(Index i, const PixelFields<4, S>& blurred, double* sums) const {
    const SsimWindow<S> window(blurred.f[0], blurred.f[1], blurred.f[2], blurred.f[3]);
    const PixelPenalty<S> pixel(rendered[i] - truth[i], penalty);
    const S dissimilarity = window.Dissimilarity();
    AddLoss(pixel, dissimilarity, sums);
    if (p == nullptr) return;
    const SsimSlopes<S> slopes(window);
    p[i] = slopes.p, q[i] = slopes.q, s[i] = slopes.s;
    if (curvature != nullptr) curvature[i] = SsimWindowCurvature(window, slopes);
  }
};

// gradient = ssim_weight * (J^T times a vector of ones) + l1_weight * (derivative of the penalty). J is the Jacobian of
// 1 - SSIM of all windows. diagonal (may be null) = ssim_weight * G(s) + l1_weight * (curvature of the penalty).
template <class S>
struct GradientOperator {
  static constexpr int kFields = 3, kSums = 0;
  const S *rendered, *truth, *p, *q, *s;
  S l1_weight, ssim_weight;
  PenaltyCoefficients<S> penalty;
  S *gradient, *diagonal;

  VESTA_HD PixelFields<3, S> Load(Index i) const { return {{p[i], q[i], s[i]}}; }
  VESTA_HD void Store(Index i, const PixelFields<3, S>& blurred, double*) const {
    const S x = rendered[i], e = x - truth[i];
    const PixelPenalty<S> pixel(e, penalty);
    gradient[i] =
        Fma(ssim_weight, SsimAdjoint(x, e, blurred.f[0], blurred.f[1], blurred.f[2]), l1_weight * pixel.derivative);
    if (diagonal != nullptr) diagonal[i] = Fma(ssim_weight, blurred.f[2], l1_weight * pixel.Curvature(penalty));
  }
};

// For SsimLinearization::kRootCenter (loss_options.h): the sums of LossSumsOperator, the gradient, and the diagonal of
// the curvature operator W (may be null).
template <class S>
struct CenterOperator {
  static constexpr int kFields = 4, kSums = 3;
  const S *rendered, *truth;
  S l1_weight, ssim_weight;
  PenaltyCoefficients<S> penalty;
  S centre;  // weight of the window's centre pixel (both axes)
  S *gradient, *diagonal;

  VESTA_HD PixelFields<4, S> Load(Index i) const {
    const S u = rendered[i] + truth[i], e = rendered[i] - truth[i];
    return {{u, e, u * u, e * e}};
  }
  VESTA_HD void Store(Index i, const PixelFields<4, S>& blurred, double* sums) const {
    const SsimWindow<S> window(blurred.f[0], blurred.f[1], blurred.f[2], blurred.f[3]);
    const SsimSlopes<S> slopes(window);
    const S x = rendered[i], e = x - truth[i], dissimilarity = window.Dissimilarity();
    const PixelPenalty<S> pixel(e, penalty);
    AddLoss(pixel, dissimilarity, sums);
    const S by_center = SsimCenterSlope(centre, x, e, slopes);
    gradient[i] = Fma(ssim_weight, by_center, l1_weight * pixel.derivative);
    if (diagonal == nullptr) return;
    diagonal[i] = Fma(l1_weight, pixel.Curvature(penalty), SsimCenterCurvature(ssim_weight, by_center, dissimilarity));
  }
};

// out = c * G(in), where * is elementwise: the first step of a product with the curvature operator W.
template <class S>
struct WeightedBlurOperator {
  static constexpr int kFields = 1, kSums = 0;
  const S *in, *c;
  S* out;

  VESTA_HD PixelFields<1, S> Load(Index i) const { return {{in[i]}}; }
  VESTA_HD void Store(Index i, const PixelFields<1, S>& blurred, double*) const { out[i] = c[i] * blurred.f[0]; }
};

// out = scale * G(in) + d * v, where * is elementwise: the second step of a product with W.
template <class S>
struct BlurAddOperator {
  static constexpr int kFields = 1, kSums = 0;
  const S* in;
  S scale;
  const S *d, *v;
  S* out;

  VESTA_HD PixelFields<1, S> Load(Index i) const { return {{in[i]}}; }
  VESTA_HD void Store(Index i, const PixelFields<1, S>& blurred, double*) const {
    out[i] = Fma(scale, blurred.f[0], d[i] * v[i]);
  }
};

}  // namespace VESTA_ISA
}  // namespace vesta

namespace vesta::device_image {

// Kernel launches of DevicePhotometricLoss, compiled by nvcc. All pointers are to GPU memory. No function waits.
//
// Number of elements of partial_sums for LossSums and Center.
Index NumPartialSums(const ImageShape& shape);
// sums: the 3 sums of LossSumsOperator.
void LossSums(const ImageShape& shape, const LossSumsOperator<float>& op, double* partial_sums, double* sums);
void Gradient(const ImageShape& shape, const GradientOperator<float>& op);
// partial_sums, sums: see LossSums.
void Center(const ImageShape& shape, const CenterOperator<float>& op, double* partial_sums, double* sums);
void WeightedBlur(const ImageShape& shape, const WeightedBlurOperator<float>& op);
void BlurAdd(const ImageShape& shape, const BlurAddOperator<float>& op);
// Applies QuantizeTo8Bit to each value.
void Quantize(Index count, float* values);

}  // namespace vesta::device_image
