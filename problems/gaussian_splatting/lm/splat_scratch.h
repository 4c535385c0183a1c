// SPDX-License-Identifier: Apache-2.0
// What a linearization of the splatting problem goes through its views in.
#pragma once

#include <vector>

#include "problems/gaussian_splatting/model/splat_backend.h"

namespace vesta::gs {

template <class B>
struct SplatScratch {
  using Vector = typename B::Vector;
  // A view at x.
  struct Unit {
    const TargetView<B>* target;
    ImageShape shape;
    typename SplatBackend<B>::SplatView view;
    Vector image;
    typename SplatBackend<B>::Loss::Linearization loss;
  };
  std::vector<Unit> units;  // all views; of JacobianKind::kRebuild one, for each in turn
  Vector image_work, weighted_work;

  // Room for so many views, whose images have so many values at most.
  void Fit(std::size_t views, Index values) {
    if (units.size() < views) units.resize(views);
    for (Vector* work : {&image_work, &weighted_work}) {
      if (work->size() < values) work->ResizeForOverwrite(values);
    }
  }
};

}  // namespace vesta::gs
