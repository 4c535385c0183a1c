// SPDX-License-Identifier: Apache-2.0
#include "tests/fuzz/splat_promise.h"

#include <cmath>

#include "splatting/io/splats/splat_file.h"

namespace vesta::fuzz {

void PromiseSplat(const gs::SplatModel& model) {
  Promise(model.sh_degree >= 0 && model.sh_degree <= 3 && model.count > 0, "no splat");
  Promise(static_cast<Index>(model.data.size()) == model.Size(), "a wrong number of values");
  for (const float value : model.data) Promise(std::isfinite(value), "a value that is not finite");
  for (Index i = 0; i < model.count; ++i) {
    bool is_zero = true;
    for (int k = 0; k < 4; ++k) is_zero = is_zero && model.attribute(splat::kQuaternion + k)[i] == 0;
    Promise(!is_zero, "a zero quaternion");
  }
  for (const float channel : model.background) Promise(channel >= 0 && channel <= 1, "a background outside 0..1");
  for (const double value : model.origin) Promise(std::isfinite(value), "an origin that is not finite");
}

void PromiseItSurvives(const gs::SplatModel& model, const std::string& copy,
                       void (*write)(const std::string& path, const gs::SplatModel& model)) {
  if (!Reads(copy, [&] { write(copy, model); })) return;
  const gs::SplatModel again = gs::ReadSplat(copy);
  PromiseSplat(again);
  Promise(again.count == model.count && again.sh_degree == model.sh_degree, "writing and reading changes the splat");
  Promise(again.background == model.background && again.has_background == model.has_background &&
              again.origin == model.origin && again.eps2d == model.eps2d && again.antialiased == model.antialiased,
          "writing and reading changes its origin or rendering");
}

}  // namespace vesta::fuzz
