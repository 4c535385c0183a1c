// SPDX-License-Identifier: Apache-2.0
// VESTA_HD marks a function for host and device. It is empty outside nvcc.
#pragma once

#if defined(__CUDACC__)
#define VESTA_HD __host__ __device__
#else
#define VESTA_HD
#endif
