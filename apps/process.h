// The running process: its age and its memory.
#pragma once

namespace vesta::app {

// Seconds since main began: the first call, which main makes, starts the clock.
double SecondsSinceStart();

// Most memory resident at any time so far, MiB.
double PeakMemoryMib();
// Memory resident now, MiB.
double MemoryMib();

}  // namespace vesta::app
