// FalloffExp of one instruction set over an array, for the test.
#pragma once

namespace vesta {

// y[i] = FalloffExp(x[i]); count is a multiple of 16.
inline namespace baseline {
void FalloffExpArray(const float* x, float* y, int count);
}
#if defined(__x86_64__)
namespace avx2 {
void FalloffExpArray(const float* x, float* y, int count);
}
namespace avx512 {
void FalloffExpArray(const float* x, float* y, int count);
}
#endif

}  // namespace vesta
