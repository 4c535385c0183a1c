// SPDX-License-Identifier: Apache-2.0
// Compares a derivative of the image by a view parameter with central differences.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "tests/kernels/gaussian_splatting/reference.h"
#include "tests/support/splat_scenes.h"

namespace vesta::test {

// changed(step): the parameter increased by `step`. Pixels near a decision are not compared.
template <class Changed>
void ExpectDerivativeOfImage(const Scene& scene, const Changed& changed, const std::vector<double>& d_image) {
  const splat::reference::Image<double> decisions = splat::reference::Render(scene);
  const double step = 1e-6;
  const std::vector<double> below = RenderedView<double>(changed(-step)).image,
                            above = RenderedView<double>(changed(step)).image;
  double scale = 1;
  for (const double value : d_image) scale = std::max(scale, std::abs(value));
  int compared = 0;
  for (std::size_t i = 0; i < d_image.size(); ++i) {
    if (decisions.margin[i % decisions.margin.size()] < 1e-3) continue;
    ++compared;
    ASSERT_NEAR((above[i] - below[i]) / (2 * step), d_image[i], 2e-5 * scale) << "entry " << i;
  }
  EXPECT_GT(compared, 0);
}

}  // namespace vesta::test
