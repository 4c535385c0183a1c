// SPDX-License-Identifier: Apache-2.0
#include "solver/internal/sparse_cholesky/front_kernels.h"

#include "kernels/core/cpu_dispatch.h"

namespace vesta {

VESTA_DECLARE_PER_ISA(const FrontKernels& CompiledFrontKernels();)

const FrontKernels& FrontKernelsFor(Isa isa) { return VESTA_OF_ISA(isa, CompiledFrontKernels)(); }

}  // namespace vesta
