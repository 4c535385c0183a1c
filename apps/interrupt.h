// Ctrl-C, and what else ends programs from outside.
#pragma once

namespace vesta::app {

// From here on the first SIGINT, SIGTERM or SIGHUP is only noted, and of SIGINT said so; the second one of its kind
// ends the program at once. Output that nobody reads any more is dropped.
void CatchInterrupts();

// Whether one was noted. To be asked between iterations.
bool Interrupted();

}  // namespace vesta::app
