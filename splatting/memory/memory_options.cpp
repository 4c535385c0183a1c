// SPDX-License-Identifier: Apache-2.0
#include "splatting/memory/memory_options.h"

namespace vesta::gs {

const schema::Table<MemoryOptions>& MemoryFields() {
  using O = MemoryOptions;
  static const schema::Table<O> fields = {
      {"budget_gib",
       &O::budget_gib,
       {0, 1e6},
       "GiB that the program may take (of the GPU with one), foreseen before they are used; 0: no limit",
       "memory_budget"},
  };
  return fields;
}

}  // namespace vesta::gs
