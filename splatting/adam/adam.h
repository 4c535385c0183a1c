// SPDX-License-Identifier: Apache-2.0
// The Adam optimiser (Kingma and Ba 2015) for a model in the memory of backend B, with a learning rate for each class
// of parameter. A Gaussian has eleven geometric parameters: mean, log-scales, quaternion and opacity. In block mode,
// Adam updates them in a basis of each Gaussian's own: the approximate eigenvectors of the running mean of g g^T, where
// g is the gradient of the eleven parameters. The second moments then belong to the directions of this basis
// (adam_formula.h).
#pragma once

#include <utility>

#include "kernels/core/check.h"
#include "kernels/core/profile.h"
#include "kernels/core/vector_backend.h"
#include "problems/gaussian_splatting/model/gather_rows.h"
#include "splatting/adam/adam_steps.h"

namespace vesta::gs {

template <class B>
class Adam {
 public:
  using Space = typename B::Space;
  using Vector = typename B::Vector;

  // metric: kBlock selects block mode. views: number of views per step (AdamRule).
  explicit Adam(const LearningRates& rates, SecondMoment metric = SecondMoment::kDiagonal, int views = 1)
      : rule_(rates, metric, views) {}

  // The unit of length of each Gaussian (model/length_units.h) multiplies the learning rate of its mean; 1 if never
  // set. Call again when the units change.
  void SetUnits(Vector units) { units_ = std::move(units); }
  const Vector& units() const { return units_; }

  // x -= step, for the attributes [0, attributes). `factor` multiplies all learning rates. `gradient` has the layout of
  // the model and is set to zero. The first call allocates the moments. Asynchronous on a device.
  void Step(const splat::ModelLayout& layout, typename B::VectorView x, float* gradient, int attributes,
            double factor) {
    const ScopedPhase phase("Adam");
    const Index count = layout.count;
    if (first_.empty()) Start(count, x.size());
    VESTA_CHECK(units_.empty() || units_.size() == count, "{} units of length for {} Gaussians", units_.size(), count);
    ++steps_;
    AdamStepArrays arrays{.blocks = rule_.BlockRates(factor, steps_),
                          .layout = layout,
                          .first_diagonal = rule_.first_diagonal(),
                          .attributes = attributes,
                          .views = rule_.views(),
                          .seen = Index{1} * steps_ * rule_.views(),
                          .rate = {}};
    arrays.blocks.count = count;
    arrays.blocks.gradient = gradient;
    arrays.blocks.parameters = x.data();
    arrays.blocks.first = first_.data();
    arrays.blocks.second = second_.data();
    arrays.blocks.units = units_.empty() ? nullptr : units_.data();
    for (int a = 0; a < attributes; ++a) arrays.rate[a] = rule_.StepRate(a, factor, steps_);
    AdamSteps<Space>::Run(arrays, bases_);
  }

  // Adapts the moments to a new model: Gaussian i of the new model (layout `to`) is Gaussian source[i] of the old one
  // (layout `from`). Its moments stay if kept[i] is 1, else become zero. On a device, throws OutOfDeviceMemory if
  // memory runs out.
  void Rearrange(const splat::ModelLayout& from, const splat::ModelLayout& to, Span<const std::uint32_t, Space> source,
                 Span<const std::uint8_t, Space> kept) {
    if (first_.empty()) return;
    // The bases are the largest arrays, so they come first. If memory is too small, this copy fails before any array
    // has changed. If the copy of the bases fits, copies of the moments fit too, unless the model grows.
    if (rule_.has_blocks()) bases_.Rearrange(source, kept);
    for (Vector* moments : {&first_, &second_}) {
      Vector gathered;
      gathered.ResizeForOverwrite(to.Size());
      GatherGaussians<Space>(from, to, source.data(), kept.data(), moments->data(), gathered.data());
      *moments = std::move(gathered);
    }
  }

  // Sets the moments of an attribute to zero.
  void Reset(const splat::ModelLayout& layout, int attribute) {
    if (first_.empty()) return;
    const auto clear = [&](Vector& moments) {
      B().Fill(0, moments.view().subspan(layout.Offset(attribute), layout.Rows(attribute)));
    };
    clear(first_);
    // In block mode the second moments belong to directions of the basis, not to attributes.
    if (attribute >= rule_.first_diagonal()) clear(second_);
  }

  void Free() {
    units_ = Vector(), first_ = Vector(), second_ = Vector();
    bases_ = BlockBases<Space>();
  }

  // Moments in the layout of the model, and the bases of block mode. In block mode, the second moments of the geometric
  // parameters are in these bases. All are empty before the first step. Without block mode, the bases are always empty.
  const Vector& first() const { return first_; }
  const Vector& second() const { return second_; }
  const BlockBases<Space>& bases() const { return bases_; }

  // Whether the state from a checkpoint fits a model of this size.
  bool IsOf(Index count, Index parameters) const {
    if (steps_ < 0 || (!units_.empty() && units_.size() != count) || first_.size() != second_.size()) return false;
    if (first_.empty()) return true;
    return first_.size() == parameters && bases_.size() == (rule_.has_blocks() ? BlockArraySize(count) : 0);
  }
  // All members except rule_, which follows from the options.
  template <class Archive>
  void Visit(Archive& archive) {
    archive(steps_, units_, first_, second_, bases_);
  }

 private:
  void Start(Index count, Index parameters) {
    first_.Resize(parameters);
    second_.Resize(parameters);
    if (rule_.has_blocks()) bases_ = BlockBases<Space>(count);
  }

  AdamRule rule_;
  int steps_ = 0;
  Vector units_, first_, second_;
  BlockBases<Space> bases_;
};

}  // namespace vesta::gs
