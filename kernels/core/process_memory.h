// The memory of the running process.
#pragma once

namespace vesta {

// From now on buffers of a mebibyte and more go back to the system when they are freed. The allocator of glibc keeps
// more and more of them for later as a process goes on, and a training whose Gaussians grow held a fifth more than it
// used. For programs, at their start; without effect elsewhere than on glibc.
void ReturnFreedMemory();

// Most memory resident at any time so far, MiB.
double PeakMemoryMib();
// Memory resident now, MiB; 0 where there is no /proc.
double MemoryMib();
// What the process may still take before the machine, or the control group it runs in, has none left, MiB; infinity
// where the system does not say.
double AvailableMemoryMib();

}  // namespace vesta
