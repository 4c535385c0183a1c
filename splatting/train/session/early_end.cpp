#include "splatting/train/session/early_end.h"

namespace vesta::gs {

bool EarlyEnd::ShouldStop(double ahead) {
  const bool is_limited = options_.time_limit > 0 && processes_.is_first();
  if (is_limited && clock_.Total() + ahead >= options_.time_limit) stopped_ = true;
  if (callbacks_.stop && callbacks_.stop()) stopped_ = true;
  return stopped_ = processes_.OnAny(stopped_);
}

}  // namespace vesta::gs
