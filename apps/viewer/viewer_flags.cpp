#include "apps/viewer/viewer_flags.h"

#include <fmt/format.h>

namespace vesta::app {

ViewerPlace PlaceOfViewer(const Flags& flags) { return {flags.bind, flags.port.value_or(0)}; }

ViewerPlace PlaceOfTrainingsView(const Flags& flags) {
  ViewerPlace place{flags.bind, 0};
  constexpr schema::Range kPorts{1, 65535};
  if (flags.view != kAnyPort && !schema::Numbers<int>::FromText(flags.view, kPorts, place.port)) {
    throw UsageError(fmt::format("--view={}: its value must be a port from 1 to 65535", flags.view));
  }
  return place;
}

}  // namespace vesta::app
