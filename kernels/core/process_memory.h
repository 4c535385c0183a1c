// SPDX-License-Identifier: Apache-2.0
// Memory use of the running process.
#pragma once

namespace vesta {

// After this call each buffer of 1 MiB or more goes back to the system as soon as it is freed. By default glibc's
// allocator keeps more and more of them: a training with a growing number of Gaussians occupied 20 % more memory than
// it used. Programs call it at their start. It has no effect without glibc.
void ReturnFreedMemoryToSystem();

// Peak resident memory so far, MiB.
double PeakMemoryMib();
// Resident memory now, MiB; 0 if /proc is missing.
double MemoryMib();
// Memory that the process can still allocate before the machine or its control group is full, MiB. Infinity if the
// system does not report it.
double AvailableMemoryMib();

}  // namespace vesta
