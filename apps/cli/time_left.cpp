#include "apps/cli/time_left.h"

#include <cmath>

namespace vesta::app {

double TimeLeft::Observe(const gs::TrainProgress& p) {
  if (!started_ || p.stage != stage_) {
    // The second stage begins where the first one ended; how long the first one's first iteration took is not known.
    start_iteration_ = started_ ? 0 : p.iteration;
    start_seconds_ = started_ ? latest_seconds_ : p.seconds;
    started_ = true;
    stage_ = p.stage;
  }
  latest_seconds_ = p.seconds;
  const int done = p.iteration - start_iteration_;
  if (done == 0) return NAN;
  return (p.seconds - start_seconds_) / done * (p.iterations - p.iteration);
}

}  // namespace vesta::app
