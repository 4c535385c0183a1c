// What the splatting problem on a GPU does to gradients of single views: what nvcc compiles.
#pragma once

#include "problems/gaussian_splatting/lm/view_agreement.h"

namespace vesta::gs::device_view_agreement {

// For all `count` entries. All pointers are to memory of the GPU; nothing waits.
void Add(const AddViewGradient<float>& add, Index count);
void Descend(const AgreedDescent<float>& descent, Index count);

}  // namespace vesta::gs::device_view_agreement
