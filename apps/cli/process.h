// The age of the running process.
#pragma once

namespace vesta::app {

// Seconds since main began: the first call, which main makes, starts the clock.
double SecondsSinceStart();

}  // namespace vesta::app
