// Where pages are served.
#pragma once

#include "apps/cli/flags.h"
#include "apps/viewer/viewer.h"

namespace vesta::app {

// Of `view`, by --port, and of a training, by --view. Throws UsageError where --view is no port.
ViewerPlace PlaceOfViewer(const Flags& flags);
ViewerPlace PlaceOfTrainingsView(const Flags& flags);

}  // namespace vesta::app
