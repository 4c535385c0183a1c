// SPDX-License-Identifier: Apache-2.0
// VESTA_HD marks a function for host and device; it is empty outside nvcc. It is one of the project's few macros.
#pragma once

#if defined(__CUDACC__)
#define VESTA_HD __host__ __device__
#else
#define VESTA_HD
#endif
