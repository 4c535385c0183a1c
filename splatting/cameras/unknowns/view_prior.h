// SPDX-License-Identifier: Apache-2.0
// What holds the freedoms that no photograph tells of (gauge.h) where cameras, exposures and splats are found at once:
// a weak pull of each view to where it was given.
#pragma once

#include <vector>

#include "splatting/cameras/unknowns/view_unknowns.h"

namespace vesta::gs {

// Adds weight / 2 (4 |v|^2 + |t|^2 / depth^2 + |gain - 1|^2 + |offset|^2) to the cost of a view, for each of its
// image's values; v: the vector part of the motion's quaternion, so that 2 |v| is the angle while that is small; t: its
// translation. Only of what is free. It biases what photographs tell little of: by the default, gains of 0.9 to 1.1 of
// small dark photographs came out up to 0.02 too near to 1, by 1e-4 up to 0.003.
struct ViewPrior {
  double weight = 0.01;  // >= 0
  double depth = 1;      // of what the views see, world units, > 0

  // Residuals, whose squares halved are that, of an image of so many values; free.num_tangent() of them.
  std::vector<double> Residuals(const ViewUnknowns& view, const FreeUnknowns& free, Index values) const;
  // Their derivative by a step of the view (Plus): square, row by row.
  std::vector<double> Jacobian(const ViewUnknowns& view, const FreeUnknowns& free, Index values) const;
};

}  // namespace vesta::gs
