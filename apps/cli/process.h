// SPDX-License-Identifier: Apache-2.0
// The run time of this process, and its reaction to Ctrl-C and other signals.
#pragma once

#include <string_view>

namespace vesta::app {

// Seconds since the first call. main calls it first, so these are seconds since the start of the program.
double SecondsSinceStart();

inline constexpr std::string_view kStopsTraining =
    "\nstopping after this iteration; press Ctrl-C again to stop at once without writing results\n";

// Installs signal handlers. The first SIGINT (Ctrl-C), SIGTERM or SIGHUP then only makes Interrupted return true;
// SIGINT also prints `message`, a static text. A second signal of the same kind ends the program at once. After SIGPIPE
// (a closed pipe), further output is discarded.
void CatchInterrupts(std::string_view message = kStopsTraining);

// Whether one of these signals has arrived. Trainings and solvers check it after each iteration.
bool Interrupted();

// Exit status of a run that a signal has stopped: 128 + SIGINT, the convention of shells. The results are written
// first.
inline constexpr int kInterruptedStatus = 130;

}  // namespace vesta::app
