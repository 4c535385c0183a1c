// SPDX-License-Identifier: Apache-2.0
// The running process: its age, and how Ctrl-C and other signals end it.
#pragma once

#include <string_view>

namespace vesta::app {

// Seconds since main began: the first call, which main makes, starts the clock.
double SecondsSinceStart();

inline constexpr std::string_view kStopsTraining =
    "\nstopping after this iteration; once more: at once, and nothing is written\n";

// From here on the first SIGINT, SIGTERM or SIGHUP is only noted, and of SIGINT told what follows: static text; the
// second one of its kind ends the program at once. Output that nobody reads any more is dropped.
void CatchInterrupts(std::string_view told = kStopsTraining);

// Whether one was noted. To be asked between iterations.
bool Interrupted();

// Exit status after Ctrl-C: 128 + SIGINT, as shells have it. Results are written all the same.
inline constexpr int kInterruptedStatus = 130;

}  // namespace vesta::app
