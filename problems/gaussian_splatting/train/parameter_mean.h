// The mean of the parameters over the last part of the Adam stage (Polyak and Juditsky 1992, "Acceleration of
// stochastic approximation by averaging"): at high rates the iterates wander about a better place than any of them is
// at. For every memory space.
#pragma once

#include "kernels/core/vector_backend.h"

namespace vesta::gs {

template <class B>
class ParameterMean {
 public:
  bool empty() const { return terms_ == 0; }
  // Of all that was added since the start; to be read only where not empty.
  const typename B::Vector& value() const { return mean_; }
  // x: as many parameters as in the calls before, since the start. Where there is no room for their mean it stays
  // empty.
  void Add(typename B::ConstView x) {
    if (empty()) mean_.ResizeForOverwrite(x.size());
    ++terms_;
    backend_.Axpby(1.0 / terms_, x, 1 - 1.0 / terms_, mean_);
  }
  // Forgets all, its memory too: for other Gaussians.
  void StartAnew() {
    terms_ = 0;
    mean_ = typename B::Vector();
  }

 private:
  B backend_;
  typename B::Vector mean_;
  int terms_ = 0;
};

}  // namespace vesta::gs
