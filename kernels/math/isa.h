// SPDX-License-Identifier: Apache-2.0
// The inline namespace of one instruction set.
//
// A template instantiated in a file compiled for AVX-512 becomes a weak symbol. Without this namespace the linker may
// choose that copy for the baseline path too, and the program dies with SIGILL on other machines. So everything below
// kernels/math, and every *.simd.cpp, lies in `namespace vesta { inline namespace VESTA_ISA {`;
// tools/check_isa_symbols.py checks it.
#pragma once

#ifndef VESTA_ISA
#define VESTA_ISA baseline
#endif
