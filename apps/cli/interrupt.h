// Ctrl-C, and what else ends programs from outside.
#pragma once

#include <string_view>

namespace vesta::app {

inline constexpr std::string_view kStopsTraining =
    "\nstopping after this iteration; once more: at once, and nothing is written\n";

// From here on the first SIGINT, SIGTERM or SIGHUP is only noted, and of SIGINT told what follows: static text; the
// second one of its kind ends the program at once. Output that nobody reads any more is dropped.
void CatchInterrupts(std::string_view told = kStopsTraining);

// Whether one was noted. To be asked between iterations.
bool Interrupted();

}  // namespace vesta::app
