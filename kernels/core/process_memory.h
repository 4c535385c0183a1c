// SPDX-License-Identifier: Apache-2.0
// The memory of the running process.
#pragma once

namespace vesta {

// From now on buffers of a mebibyte and more go back to the system when they are freed. The allocator of glibc would
// keep more and more of them for later use: a training whose Gaussians grow in number held a fifth more memory than it
// used. Programs call it at their start. It has an effect with glibc only.
void ReturnFreedMemory();

// Most memory resident at any time so far, MiB.
double PeakMemoryMib();
// Memory resident now, MiB; 0 where there is no /proc.
double MemoryMib();
// Memory that the process may still take before the machine, or the control group it runs in, is full, MiB; infinity
// where the system does not tell.
double AvailableMemoryMib();

}  // namespace vesta
