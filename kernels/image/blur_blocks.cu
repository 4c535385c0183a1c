// SPDX-License-Identifier: Apache-2.0
#include "kernels/core/launch.cuh"
#include "kernels/image/blur_blocks.h"
#include "kernels/image/metrics.h"

namespace vesta::device_image {
namespace {

template <class Operator>
void Run(const ImageShape& shape, const WindowTaps<float>& taps, const Operator& op, double* partial_sums,
         const char* name) {
  using Kernel = BlurBlock<float, Operator>;
  device::Launch(Kernel{shape.width, shape.height, taps, op, partial_sums},
                 Kernel::NumBlocks(shape.width, shape.height), name);
}
template <class Operator>
void Run(const ImageShape& shape, const Operator& op, const char* name) {
  Run(shape, MakeWindowTaps<float>(), op, nullptr, name);
}
// Launches operators that also compute the three sums of the loss.
template <class Operator>
void RunWithSums(const ImageShape& shape, const Operator& op, double* partial_sums, double* sums, const char* name) {
  constexpr int kSums = Operator::kSums;
  Run(shape, MakeWindowTaps<float>(), op, partial_sums, name);
  device::Launch(SumPartials<kSums>{partial_sums, NumPartialSums(shape) / kSums, sums}, kSums, "sums of the loss");
}

struct QuantizeOne {
  float* values;
  VESTA_HD void operator()(Index i) const { values[i] = QuantizeTo8Bit(values[i]); }
};

}  // namespace

Index NumPartialSums(const ImageShape& shape) {
  return LossSumsOperator<float>::kSums *
         BlurBlock<float, LossSumsOperator<float>>::NumBlocks(shape.width, shape.height);
}

void LossSums(const ImageShape& shape, const LossSumsOperator<float>& op, double* partial_sums, double* sums) {
  RunWithSums(shape, op, partial_sums, sums, "SSIM windows");
}
void Center(const ImageShape& shape, const CenterOperator<float>& op, double* partial_sums, double* sums) {
  RunWithSums(shape, op, partial_sums, sums, "loss gradient by centres");
}

void Gradient(const ImageShape& shape, const GradientOperator<float>& op) { Run(shape, op, "loss gradient"); }
void WeightedBlur(const ImageShape& shape, const WeightedBlurOperator<float>& op) { Run(shape, op, "weighted blur"); }
void BlurAdd(const ImageShape& shape, const BlurAddOperator<float>& op) { Run(shape, op, "blur and add"); }

void Quantize(Index count, float* values) { device::ForEach(count, QuantizeOne{values}, "quantization"); }

}  // namespace vesta::device_image
