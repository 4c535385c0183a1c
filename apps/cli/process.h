// SPDX-License-Identifier: Apache-2.0
// The running process: its run time, and its reaction to Ctrl-C and other signals.
#pragma once

#include <string_view>

namespace vesta::app {

// Seconds since the first call, which main makes at its start.
double SecondsSinceStart();

inline constexpr std::string_view kStopsTraining =
    "\nstopping after this iteration; press Ctrl-C again to stop at once without writing results\n";

// After this call, the first SIGINT, SIGTERM or SIGHUP only sets a flag; SIGINT also prints `message`, a static text. A
// second signal of the same kind ends the program at once. After SIGPIPE, output is discarded.
void CatchInterrupts(std::string_view message = kStopsTraining);

// Whether a signal has arrived. Poll it between iterations.
bool Interrupted();

// Exit status after Ctrl-C, by the convention of shells: 128 + SIGINT. Results are written nevertheless.
inline constexpr int kInterruptedStatus = 130;

}  // namespace vesta::app
