// SPDX-License-Identifier: Apache-2.0
// The inline namespace of one instruction set.
//
// A template that is instantiated in a file compiled for AVX-512 becomes a weak symbol. Without this namespace, the
// linker could use this copy also in code for older CPUs, where the program would stop with SIGILL. All code in
// kernels/math and every *.simd.cpp is therefore in `namespace vesta { inline namespace VESTA_ISA {`.
// tools/check_isa_symbols.py checks this.
#pragma once

#ifndef VESTA_ISA
#define VESTA_ISA baseline
#endif
