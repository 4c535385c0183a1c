// SPDX-License-Identifier: Apache-2.0
#include "bench/deconvolution/separable_correlation.h"

#include "kernels/core/cpu_dispatch.h"

namespace vesta::deconvolution {

VESTA_DECLARE_PER_ISA(CorrelateRows CompiledCorrelateRows();)

CorrelateRows CorrelateRowsFor(Isa isa) { return VESTA_OF_ISA(isa, CompiledCorrelateRows)(); }

}  // namespace vesta::deconvolution
