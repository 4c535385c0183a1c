// SPDX-License-Identifier: Apache-2.0
// Memory use of the running process.
#pragma once

namespace vesta {

// Makes glibc return each buffer of 1 MiB or more to the system as soon as it is freed, and keep up to 16 MiB of the
// smaller ones. By default, glibc keeps more and more freed buffers while the sizes grow. Programs call this function
// at their start. No effect without glibc.
void ReturnFreedMemoryToSystem();

// Peak resident memory so far, MiB.
double PeakMemoryMib();
// Resident memory now, MiB; 0 if /proc is missing.
double MemoryMib();
// Memory that the process can still allocate before the machine or its control group is full, MiB. Infinity if unknown.
double AvailableMemoryMib();

}  // namespace vesta
