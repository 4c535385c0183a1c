// SPDX-License-Identifier: Apache-2.0
// The launches behind DevicePhotometricLoss, compiled by nvcc. All pointers are to memory of the GPU. No function
// waits.
#pragma once

#include "kernels/image/blur_blocks.h"

namespace vesta::device_image {

// Room for the partial sums of Windows.
Index NumPartialSums(const ImageShape& shape);
// sums: three.
void Windows(const ImageShape& shape, const WindowsOperator<float>& op, double* partial_sums, double* sums);
void Gradient(const ImageShape& shape, const GradientOperator<float>& op);
// partial_sums, sums: as for Windows.
void Center(const ImageShape& shape, const CenterOperator<float>& op, double* partial_sums, double* sums);
void WeightedBlur(const ImageShape& shape, const WeightedBlurOperator<float>& op);
void BlurAdd(const ImageShape& shape, const BlurAddOperator<float>& op);
// QuantizeTo8Bit on each value.
void Quantize(Index count, float* values);

}  // namespace vesta::device_image
