// One observation of a bundle adjustment as a functor of its twelve parameters.
#pragma once

#include "problems/bundle_adjustment/projection.h"

namespace vesta::bundle {

// Residual: predicted less observed, pixels. Parameters: the point's three, then the camera's nine.
struct BundleObservation {
  static constexpr int kResiduals = 2, kParameters = kRowSize;
  double u, v;

  template <class T>
  VESTA_HD void operator()(const T* p, T* r) const {
    const Projection<T> seen = Project(MakeCamera(p + kPointSize), p);
    r[0] = seen.predicted[0] - T(u);
    r[1] = seen.predicted[1] - T(v);
  }
};

}  // namespace vesta::bundle
