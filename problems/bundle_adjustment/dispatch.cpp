// Picks the kernels of an instruction set.
#include "problems/bundle_adjustment/kernels.h"

namespace vesta::bundle {

inline namespace baseline {
const Kernels<float>& FloatKernels();
const Kernels<double>& DoubleKernels();
SymmetricProduct GetSymmetricProduct();
}  // namespace baseline
#if defined(__x86_64__)
namespace avx2 {
const Kernels<float>& FloatKernels();
const Kernels<double>& DoubleKernels();
SymmetricProduct GetSymmetricProduct();
}  // namespace avx2
namespace avx512 {
const Kernels<float>& FloatKernels();
const Kernels<double>& DoubleKernels();
SymmetricProduct GetSymmetricProduct();
}  // namespace avx512
#endif

namespace {

template <class T>
T Choose(Isa isa, T baseline_one, T avx2_one, T avx512_one) {
  switch (isa) {
    case Isa::kAvx2:
      return avx2_one;
    case Isa::kAvx512:
      return avx512_one;
    default:
      return baseline_one;
  }
}

}  // namespace

#if defined(__x86_64__)
template <>
const Kernels<float>& KernelsOf<float>(Isa isa) {
  return Choose(isa, baseline::FloatKernels, avx2::FloatKernels, avx512::FloatKernels)();
}
template <>
const Kernels<double>& KernelsOf<double>(Isa isa) {
  return Choose(isa, baseline::DoubleKernels, avx2::DoubleKernels, avx512::DoubleKernels)();
}
SymmetricProduct SymmetricProductOf(Isa isa) {
  return Choose(isa, baseline::GetSymmetricProduct, avx2::GetSymmetricProduct, avx512::GetSymmetricProduct)();
}
#else
template <>
const Kernels<float>& KernelsOf<float>(Isa) {
  return baseline::FloatKernels();
}
template <>
const Kernels<double>& KernelsOf<double>(Isa) {
  return baseline::DoubleKernels();
}
SymmetricProduct SymmetricProductOf(Isa) { return baseline::GetSymmetricProduct(); }
#endif

}  // namespace vesta::bundle
