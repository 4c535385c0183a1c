// SPDX-License-Identifier: Apache-2.0
// Adam (Kingma and Ba 2015) on a model, a rate for each class of parameter, each parameter by itself or the geometric
// ones of a Gaussian together. For every memory space.
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

  // views: that each step is by (AdamRule).
  explicit Adam(const LearningRates& rates, SecondMoment metric = SecondMoment::kDiagonal, int views = 1)
      : rule_(rates, metric, views) {}

  // The unit of length of each Gaussian of the model (model/length_units.h), to be set anew when those change; without
  // it 1.
  void SetUnits(Vector units) { units_ = std::move(units); }
  const Vector& units() const { return units_; }

  // x -= step, for attributes [0, attributes) of a model so laid out, all rates times `factor`; gradient laid out as
  // the model, zero afterwards. Moments are made on first use. On a device it does not wait.
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

  // Follow a change of the model: Gaussian i of the new one, laid out as `to`, is source[i] of the old one, with its
  // moments where kept[i], else with none. On a device throws OutOfDeviceMemory.
  void Rearrange(const splat::ModelLayout& from, const splat::ModelLayout& to, Span<const std::uint32_t, Space> source,
                 Span<const std::uint8_t, Space> kept) {
    if (first_.empty()) return;
    // The bases, being the most, first: if they fit, so do the moments of a model that does not grow.
    if (rule_.has_blocks()) bases_.Rearrange(source, kept);
    for (Vector* moments : {&first_, &second_}) {
      Vector gathered;
      gathered.ResizeForOverwrite(to.Size());
      GatherGaussians<Space>(from, to, source.data(), kept.data(), moments->data(), gathered.data());
      *moments = std::move(gathered);
    }
  }

  // Forgets the moments of one attribute of a model so laid out.
  void Reset(const splat::ModelLayout& layout, int attribute) {
    if (first_.empty()) return;
    const auto clear = [&](Vector& moments) {
      B().Fill(0, moments.view().subspan(layout.Offset(attribute), layout.Rows(attribute)));
    };
    clear(first_);
    // Of a block the second moments are those of directions, not of attributes: they stay.
    if (attribute >= rule_.first_diagonal()) clear(second_);
  }

  // Frees the moments, bases and units.
  void Free() {
    units_ = Vector(), first_ = Vector(), second_ = Vector();
    bases_ = BlockBases<Space>();
  }

  // Moments laid out as the model, of blocks the second ones in the basis; empty before the first step. Bases are empty
  // unless stepped in blocks.
  const Vector& first() const { return first_; }
  const Vector& second() const { return second_; }
  const BlockBases<Space>& bases() const { return bases_; }

  // Whether what was read can be that of such a model.
  bool IsOf(Index count, Index parameters) const {
    if (steps_ < 0 || (!units_.empty() && units_.size() != count) || first_.size() != second_.size()) return false;
    if (first_.empty()) return true;
    return first_.size() == parameters && bases_.size() == (rule_.has_blocks() ? BlockArraySize(count) : 0);
  }
  // All but rates and metric, which are options.
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
