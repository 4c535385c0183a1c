// SPDX-License-Identifier: Apache-2.0
// The mean of the parameters over the last part of the Adam stage (Polyak and Juditsky 1992, "Acceleration of
// stochastic approximation by averaging"): at high rates the iterates wander about a better place than any of them is
// at. That place still moves, so the later ones weigh more: polynomial-decay averaging (Shamir and Zhang 2013,
// "Stochastic gradient descent for non-smooth optimization", section 4). For every memory space.
#pragma once

#include "kernels/core/profile.h"
#include "kernels/core/vector_backend.h"
#include "problems/gaussian_splatting/model/gather_rows.h"

namespace vesta::gs {

template <class B>
class ParameterMean {
 public:
  // The t-th of T terms weighs about as t to this power; nearly all is in the last T / 3 or so. 0 would be the plain
  // mean. (docs/decisions/parameter-averaging.md)
  static constexpr int kExponent = 8;

  bool empty() const { return terms_ == 0; }
  // The weighted mean of all that was added since the start; to be read only where not empty.
  const typename B::Vector& value() const { return mean_; }
  // x: as many parameters as in the calls before, since the start. Where there is no room for their mean it stays
  // empty.
  void Add(typename B::ConstVectorView x) {
    const ScopedPhase phase("parameter mean");
    if (empty()) mean_.ResizeForOverwrite(x.size());
    ++terms_;
    const double weight = (kExponent + 1.0) / (terms_ + kExponent);
    backend_.Axpby(weight, x, 1 - weight, mean_);
  }
  // The mean of Gaussians source[k], laid out as `to`, of those of a model laid out as `from`.
  ParameterMean OfRows(const splat::ModelLayout& from, const splat::ModelLayout& to,
                       Span<const std::uint32_t, typename B::Space> source) const {
    ParameterMean rows;
    if (empty()) return rows;
    rows.terms_ = terms_;
    rows.mean_.ResizeForOverwrite(to.Size());
    GatherGaussians<typename B::Space>(from, to, source.data(), nullptr, mean_.data(), rows.mean_.data());
    return rows;
  }
  // Whether what was read can be that of so many parameters.
  bool IsOf(Index parameters) const { return terms_ == 0 || (terms_ > 0 && mean_.size() == parameters); }
  // Forgets all, its memory too: for other Gaussians.
  void StartAnew() {
    terms_ = 0;
    mean_ = typename B::Vector();
  }

  template <class Archive>
  void Visit(Archive& archive) {
    archive(terms_, mean_);
  }

 private:
  B backend_;
  typename B::Vector mean_;
  int terms_ = 0;
};

}  // namespace vesta::gs
