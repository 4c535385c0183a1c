// SPDX-License-Identifier: Apache-2.0
#include "apps/cli/version.h"

#include <fmt/format.h>

#include "kernels/core/cpu_dispatch.h"

namespace vesta::app {
namespace {

// Other processors than x86 have only the baseline.
#if defined(__x86_64__)
constexpr Isa kCompiled[] = {Isa::kBaseline, Isa::kAvx2, Isa::kAvx512};
#else
constexpr Isa kCompiled[] = {Isa::kBaseline};
#endif

}  // namespace

std::string VersionNumber() { return VESTA_VERSION; }

std::string Version() { return fmt::format("{} (commit {})", VersionNumber(), kCommit); }

std::string VersionText() {
  std::string compiled, available;
  for (const Isa isa : kCompiled) {
    compiled += fmt::format(" {}", IsaName(isa));
    if (IsaAvailable(isa)) available += fmt::format(" {}", IsaName(isa));
  }
  return fmt::format("vesta {}\ninstruction sets:{}; this CPU has{}; used: {}\n", Version(), compiled, available,
                     IsaName(ActiveIsa()));
}

}  // namespace vesta::app
