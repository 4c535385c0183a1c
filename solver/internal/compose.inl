// SPDX-License-Identifier: Apache-2.0
// Definitions for solver/compose.h.
#pragma once

#include "kernels/core/check.h"
#include "solver/compose.h"

namespace vesta {

template <Backend B>
ProductMap<B>::ProductMap(LinearMap<B>& outer, LinearMap<B>& inner)
    : outer_(outer), inner_(inner), between_(inner.rows()) {
  VESTA_CHECK(outer.cols() == inner.rows(), "product of a map of {} columns and one of {} rows", outer.cols(),
              inner.rows());
}

template <Backend B>
void ProductMap<B>::Apply(typename B::ConstVectorView x, typename B::VectorView y) {
  inner_.Apply(x, between_);
  outer_.Apply(between_, y);
}

template <Backend B>
void ProductMap<B>::ApplyAdjoint(typename B::ConstVectorView y, typename B::VectorView x) {
  outer_.ApplyAdjoint(y, between_);
  inner_.ApplyAdjoint(between_, x);
}

template <Backend B>
ScaledRows<B>::ScaledRows(typename B::ConstVectorView d, LinearMap<B>& a) : d_(d), a_(a), work_(a.rows()) {
  VESTA_CHECK(d.size() == a.rows(), "{} scales for {} rows", d.size(), a.rows());
}

template <Backend B>
void ScaledRows<B>::Apply(typename B::ConstVectorView x, typename B::VectorView y) {
  a_.Apply(x, y);
  B().Multiply(d_, y, y);
}

template <Backend B>
void ScaledRows<B>::ApplyAdjoint(typename B::ConstVectorView y, typename B::VectorView x) {
  B().Multiply(d_, y, work_);
  a_.ApplyAdjoint(work_, x);
}

template <Backend B>
ScaledColumns<B>::ScaledColumns(LinearMap<B>& a, typename B::ConstVectorView d) : a_(a), d_(d), work_(a.cols()) {
  VESTA_CHECK(d.size() == a.cols(), "{} scales for {} columns", d.size(), a.cols());
}

template <Backend B>
void ScaledColumns<B>::Apply(typename B::ConstVectorView x, typename B::VectorView y) {
  B().Multiply(d_, x, work_);
  a_.Apply(work_, y);
}

template <Backend B>
void ScaledColumns<B>::ApplyAdjoint(typename B::ConstVectorView y, typename B::VectorView x) {
  a_.ApplyAdjoint(y, x);
  B().Multiply(d_, x, x);
}

}  // namespace vesta
