// SPDX-License-Identifier: Apache-2.0
#include "kernels/core/check.h"

#include <string_view>

namespace vesta {

void FailCheck(const char* condition, const char* file, int line, const std::string& message) {
  std::string_view path(file);
  const auto slash = path.rfind('/');
  if (slash != std::string_view::npos) path.remove_prefix(slash + 1);
  throw Error(kBadArgument, fmt::format("{} (check '{}' failed at {}:{})", message, condition, path, line));
}

}  // namespace vesta
