// SPDX-License-Identifier: Apache-2.0
// Weighted mean of the parameters over the last part of the Adam stage (Polyak and Juditsky 1992, "Acceleration of
// stochastic approximation by averaging"). At high learning rates, the parameters move around a point that is better
// than each of them. This point moves too, so later parameters have larger weights: polynomial-decay averaging (Shamir
// and Zhang 2013, "Stochastic gradient descent for non-smooth optimization", section 4).
#pragma once

#include "kernels/core/profile.h"
#include "kernels/core/vector_backend.h"
#include "problems/gaussian_splatting/model/gather_rows.h"

namespace vesta::gs {

template <class B>
class ParameterMean {
 public:
  // The t-th of T terms has a weight of about t^kExponent, so nearly all weight is on the last T / 3 terms; kExponent =
  // 0 would be the plain mean (docs/decisions/parameter-averaging.md).
  static constexpr int kExponent = 8;

  bool empty() const { return terms_ == 0; }
  // The mean of the terms since construction or Clear. Only valid if not empty.
  const typename B::Vector& value() const { return mean_; }
  // All terms must have the same size. If a device has too little memory for the first term, throws OutOfDeviceMemory
  // and stays empty.
  void Add(typename B::ConstVectorView x) {
    const ScopedPhase phase("parameter mean");
    if (empty()) mean_.ResizeForOverwrite(x.size());
    ++terms_;
    const double weight = (kExponent + 1.0) / (terms_ + kExponent);
    backend_.Axpby(weight, x, 1 - weight, mean_);
  }
  // The mean for other Gaussians: Gaussian k of the result (layout `to`) is Gaussian source[k] of this mean
  // (layout `from`).
  ParameterMean OfRows(const splat::ModelLayout& from, const splat::ModelLayout& to,
                       Span<const std::uint32_t, typename B::Space> source) const {
    ParameterMean rows;
    if (empty()) return rows;
    rows.terms_ = terms_;
    rows.mean_.ResizeForOverwrite(to.Size());
    GatherGaussians<typename B::Space>(from, to, source.data(), nullptr, mean_.data(), rows.mean_.data());
    return rows;
  }
  // Whether the state from a checkpoint fits a model with this many parameters.
  bool IsOf(Index parameters) const { return terms_ == 0 || (terms_ > 0 && mean_.size() == parameters); }
  // Removes all terms and frees the memory.
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
