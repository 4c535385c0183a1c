#include "bench/solver_race/race.h"

#include <cstring>
#include <limits>

#include "bench/child_process.h"

namespace vesta::bench {

double Run::SecondsTo(double cost) const {
  for (const Moment& moment : moments) {
    if (moment.cost <= cost) return moment.seconds;
  }
  return std::numeric_limits<double>::infinity();
}

Run RunAlone(const Contender& contender, int times) {
  const ChildResult child = RunInChild(contender.name, [&](const Send& send) {
    for (int early = 1; early < times; ++early) contender.run();
    const std::vector<Moment> moments = contender.run();
    send(moments.data(), moments.size() * sizeof(Moment));
  });
  Run run;
  run.moments.resize(child.bytes.size() / sizeof(Moment));
  std::memcpy(run.moments.data(), child.bytes.data(), run.moments.size() * sizeof(Moment));
  run.failed = child.failed || run.moments.empty();
  run.peak_mib = child.peak_mib;
  return run;
}

}  // namespace vesta::bench
