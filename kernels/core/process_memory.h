// SPDX-License-Identifier: Apache-2.0
// Memory use of the running process.
#pragma once

namespace vesta {

// Makes freed buffers of 1 MiB and more return to the system from now on. glibc's allocator would otherwise keep more
// and more of them: a training with a growing number of Gaussians held 20 % more memory than it used. Programs call it
// at their start. It only has an effect with glibc.
void ReturnFreedMemory();

// Peak resident memory so far, MiB.
double PeakMemoryMib();
// Resident memory now, MiB; 0 if /proc is missing.
double MemoryMib();
// Memory that the process can still allocate before the machine or its control group is full, MiB. Infinity if the
// system does not report it.
double AvailableMemoryMib();

}  // namespace vesta
