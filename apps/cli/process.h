// SPDX-License-Identifier: Apache-2.0
// Run time of this process, and its reaction to Ctrl-C and other signals.
#pragma once

#include <string_view>

namespace vesta::app {

// Seconds since the first call, which main makes at its start.
double SecondsSinceStart();

inline constexpr std::string_view kStopsTraining =
    "\nstopping after this iteration; press Ctrl-C again to stop at once without writing results\n";

// After this call, the first SIGINT (Ctrl-C), SIGTERM or SIGHUP only makes Interrupted return true; SIGINT also prints
// `message`, a static text. A second signal of the same kind ends the program at once. After SIGPIPE (a closed pipe),
// further output is discarded.
void CatchInterrupts(std::string_view message = kStopsTraining);

// Whether such a signal has arrived. Trainings and solvers check this after each iteration.
bool Interrupted();

// Exit status of a run that a signal stopped and that wrote its results: 128 + SIGINT, the convention of shells.
inline constexpr int kInterruptedStatus = 130;

}  // namespace vesta::app
