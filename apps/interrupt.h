// Ctrl-C.
#pragma once

namespace vesta::app {

// From here on the first SIGINT or SIGTERM is only noted; the second one of its kind ends the program at once.
void CatchInterrupts();

// Whether one was noted. To be asked between iterations.
bool Interrupted();

}  // namespace vesta::app
