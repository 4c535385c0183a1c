// SPDX-License-Identifier: Apache-2.0
#include "kernels/image/image_kernels.h"

#include "kernels/core/cpu_dispatch.h"

namespace vesta {

VESTA_DECLARE_PER_ISA(template <class S> const ImageKernels<S>& CompiledImageKernels();)

template <class S>
const ImageKernels<S>& ImageKernelsFor(Isa isa) {
  return VESTA_OF_ISA(isa, CompiledImageKernels<S>)();
}

template const ImageKernels<float>& ImageKernelsFor<float>(Isa);
template const ImageKernels<double>& ImageKernelsFor<double>(Isa);

}  // namespace vesta
