#include "problems/gaussian_splatting/train/early_end.h"

namespace vesta::gs {

bool EarlyEnd::ShouldStop(double ahead) {
  if (options_.time_limit > 0 && clock_.Total() + ahead >= options_.time_limit) stopped_ = true;
  if (callbacks_.stop && callbacks_.stop()) stopped_ = true;
  return stopped_ = together_.OnAny(stopped_);
}

}  // namespace vesta::gs
