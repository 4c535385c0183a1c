// SPDX-License-Identifier: Apache-2.0
// The inline namespace of one instruction set.
//
// A template instantiated in a file compiled for AVX-512 becomes a weak symbol. Without this namespace the linker could
// choose that copy for the baseline path too, and the program would die with SIGILL on older CPUs. All code in
// kernels/math and every *.simd.cpp is therefore in `namespace vesta { inline namespace VESTA_ISA {`.
// tools/check_isa_symbols.py checks this.
#pragma once

#ifndef VESTA_ISA
#define VESTA_ISA baseline
#endif
