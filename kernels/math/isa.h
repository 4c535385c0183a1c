// SPDX-License-Identifier: Apache-2.0
// The inline namespace of one instruction set.
//
// A template instantiated in a file compiled for AVX-512 becomes a weak symbol. Without this namespace, the linker
// could use this copy for older CPUs, and the program would stop there with SIGILL. All code in kernels/math and every
// *.simd.cpp is therefore in `namespace vesta { inline namespace VESTA_ISA {` (checked by tools/check_isa_symbols.py).
#pragma once

#ifndef VESTA_ISA
#define VESTA_ISA baseline
#endif
