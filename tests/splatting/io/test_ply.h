// SPDX-License-Identifier: Apache-2.0
// A splat with random valid values.
#pragma once

#include <cmath>
#include <cstring>
#include <random>

#include "splatting/io/splats/ply.h"
#include "tests/support/test_files.h"

namespace vesta::gs {

inline SplatModel ExampleSplat(int degree, Index count) {
  std::mt19937 random(11);
  SplatModel model;
  model.Resize(degree, count);
  for (float& v : model.data) v = static_cast<float>(random() % 20001) / 7000.0f - 1.0f;
  for (Index i = 0; i < count; ++i) model.attribute(splat::kQuaternion)[i] = 1;
  return model;
}

}  // namespace vesta::gs
