// SPDX-License-Identifier: Apache-2.0
// Mean of the parameters over the last part of the Adam stage, in any memory space (Polyak and Juditsky 1992,
// "Acceleration of stochastic approximation by averaging"). At high learning rates, the iterates move around a point
// that is better than each of them. This point still moves, so later iterates have larger weights: polynomial-decay
// averaging (Shamir and Zhang 2013, "Stochastic gradient descent for non-smooth optimization", section 4).
#pragma once

#include "kernels/core/profile.h"
#include "kernels/core/vector_backend.h"
#include "problems/gaussian_splatting/model/gather_rows.h"

namespace vesta::gs {

template <class B>
class ParameterMean {
 public:
  // The t-th of T terms has a weight of about t^kExponent, so nearly all weight is on the last T / 3 terms. 0 would be
  // the plain mean. (docs/decisions/parameter-averaging.md)
  static constexpr int kExponent = 8;

  bool empty() const { return terms_ == 0; }
  // The weighted mean since the start. Only valid if not empty.
  const typename B::Vector& value() const { return mean_; }
  // x must have the same size in all calls since the start. If memory for the mean cannot be allocated, the mean stays
  // empty.
  void Add(typename B::ConstVectorView x) {
    const ScopedPhase phase("parameter mean");
    if (empty()) mean_.ResizeForOverwrite(x.size());
    ++terms_;
    const double weight = (kExponent + 1.0) / (terms_ + kExponent);
    backend_.Axpby(weight, x, 1 - weight, mean_);
  }
  // The mean for the Gaussians source[k] of this model: `from` is its layout, `to` the layout of the result.
  ParameterMean OfRows(const splat::ModelLayout& from, const splat::ModelLayout& to,
                       Span<const std::uint32_t, typename B::Space> source) const {
    ParameterMean rows;
    if (empty()) return rows;
    rows.terms_ = terms_;
    rows.mean_.ResizeForOverwrite(to.Size());
    GatherGaussians<typename B::Space>(from, to, source.data(), nullptr, mean_.data(), rows.mean_.data());
    return rows;
  }
  // Whether the state read from a checkpoint fits a model with this many parameters.
  bool IsOf(Index parameters) const { return terms_ == 0 || (terms_ > 0 && mean_.size() == parameters); }
  // Clears the mean and frees its memory, for use with other Gaussians.
  void Clear() {
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
