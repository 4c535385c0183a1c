// SPDX-License-Identifier: Apache-2.0
#include "bench/solver_race/race.h"

#include <algorithm>
#include <cstring>
#include <limits>

#include "bench/child_process.h"

namespace vesta::bench {

const Moment* Run::FirstWithin(double cost) const {
  const auto first = std::find_if(moments.begin(), moments.end(), [&](const Moment& m) { return m.cost <= cost; });
  return first == moments.end() ? nullptr : &*first;
}

double Run::SecondsTo(double cost) const {
  const Moment* first = FirstWithin(cost);
  return first ? first->seconds : std::numeric_limits<double>::infinity();
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
