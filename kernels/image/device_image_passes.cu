#include "kernels/core/launch.cuh"
#include "kernels/image/device_image_passes.h"

namespace vesta::device_image {
namespace {

template <class Operator>
void Run(const ImageShape& shape, const Operator& op, double* partial_sums, const char* name) {
  using Kernel = BlurBlock<float, Operator>;
  device::Launch(Kernel{shape.width, shape.height, MakeWindowTaps<float>(), op, partial_sums},
                 Kernel::NumBlocks(shape.width, shape.height), name);
}

}  // namespace

Index NumPartialSums(const ImageShape& shape) {
  return WindowsOperator<float>::kSums * BlurBlock<float, WindowsOperator<float>>::NumBlocks(shape.width, shape.height);
}

void Windows(const ImageShape& shape, const WindowsOperator<float>& op, double* partial_sums, double* sums) {
  constexpr int kSums = WindowsOperator<float>::kSums;
  Run(shape, op, partial_sums, "SSIM windows");
  device::Launch(SumPartials<kSums>{partial_sums, NumPartialSums(shape) / kSums, sums}, kSums, "sums of the loss");
}

void Gradient(const ImageShape& shape, const GradientOperator<float>& op) { Run(shape, op, nullptr, "loss gradient"); }
void SsimTangents(const ImageShape& shape, const SsimTangentOperator<float>& op) {
  Run(shape, op, nullptr, "SSIM tangent");
}
void SsimAdjoints(const ImageShape& shape, const SsimAdjointOperator<float>& op) {
  Run(shape, op, nullptr, "SSIM adjoint");
}
void WeightedBlur(const ImageShape& shape, const WeightedBlurOperator<float>& op) {
  Run(shape, op, nullptr, "weighted blur");
}
void BlurAdd(const ImageShape& shape, const BlurAddOperator<float>& op) { Run(shape, op, nullptr, "blur and add"); }

}  // namespace vesta::device_image
