// Options changed by text, as benchmarks list them.
#pragma once

#include <string>

#include "problems/gaussian_splatting/train/options.h"

namespace vesta::bench {

// The options with these changes: KEY=VALUE ... with spaces between, the keys those of gs::TrainFields. KEY=xF
// multiplies the number that is there by F (whole ones are rounded down, to 1 at least); ROOM=PRESET takes all that the
// preset has in this room. Throws Error, one line, for whatever that is not.
gs::TrainOptions Changed(gs::TrainOptions options, const std::string& changes);

}  // namespace vesta::bench
