// SPDX-License-Identifier: Apache-2.0
// Picks the kernels of an instruction set.
#include "kernels/core/cpu_dispatch.h"
#include "problems/bundle_adjustment/kernels.h"

namespace vesta::bundle {

VESTA_DECLARE_PER_ISA(template <class S> const Kernels<S>& CompiledKernels();
                      SymmetricProduct CompiledSymmetricProduct();)

template <class S>
const Kernels<S>& KernelsFor(Isa isa) {
  return VESTA_OF_ISA(isa, CompiledKernels<S>)();
}

template const Kernels<float>& KernelsFor<float>(Isa);
template const Kernels<double>& KernelsFor<double>(Isa);

SymmetricProduct SymmetricProductFor(Isa isa) { return VESTA_OF_ISA(isa, CompiledSymmetricProduct)(); }

}  // namespace vesta::bundle
