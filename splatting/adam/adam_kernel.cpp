// SPDX-License-Identifier: Apache-2.0
#include "splatting/adam/adam_kernel.h"

#include "kernels/core/cpu_dispatch.h"

namespace vesta::gs {

VESTA_DECLARE_PER_ISA(const AdamKernels& CompiledAdamKernels();)

const AdamKernels& AdamKernelsFor(Isa isa) { return VESTA_OF_ISA(isa, CompiledAdamKernels)(); }

}  // namespace vesta::gs
