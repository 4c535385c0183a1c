// SPDX-License-Identifier: Apache-2.0
#include "problems/bundle_adjustment/bundle_parts.h"

#include <algorithm>
#include <utility>

#include "kernels/core/check.h"
#include "problems/bundle_adjustment/projection.h"

namespace vesta::bundle {

BundleParts::BundleParts(const BundleData& data, int num_parts, BundleProblemOptions options)
    : data_(data), options_(std::move(options)) {
  if (num_parts < 1) Fail(kBadArgument, "num_parts is {}; it must be at least 1", num_parts);
  const auto points = static_cast<std::size_t>(data.num_points);
  first_.assign(points + 1, 0);
  for (const Observation& o : data.observations) {
    if (o.point < 0 || o.point >= data.num_points)
      Fail(kBadArgument, "an observation refers to point {}, but there are {} points", o.point, data.num_points);
    ++first_[static_cast<std::size_t>(o.point) + 1];
  }
  for (std::size_t i = 0; i < points; ++i) first_[i + 1] += first_[i];
  by_point_.resize(data.observations.size());
  std::vector<Index> next(first_.begin(), first_.end() - 1);
  for (std::size_t k = 0; k < data.observations.size(); ++k) {
    by_point_[static_cast<std::size_t>(next[static_cast<std::size_t>(data.observations[k].point)]++)] =
        static_cast<Index>(k);
  }
  const auto parts = std::clamp<Index>(num_parts, 1, std::max<Index>(data.num_points, 1));
  const auto observations = static_cast<Index>(data.observations.size());
  first_point_.reserve(static_cast<std::size_t>(parts) + 1);
  for (Index part = 0; part <= parts; ++part) {
    // Every part gets at least one point.
    const auto cut = std::lower_bound(first_.begin(), first_.end() - 1, observations * part / parts) - first_.begin();
    const Index least = part == 0 ? 0 : first_point_.back() + 1;
    const Index most = data.num_points - (parts - part);  // leaves one point for each later part
    first_point_.push_back(part == 0 ? 0 : part == parts ? data.num_points : std::clamp<Index>(cut, least, most));
  }
}

Index BundleParts::num_parameters() const { return kCameraSize * data_.num_cameras + kPointSize * data_.num_points; }

std::vector<BlockGroup> BundleParts::block_groups() const {
  return {{kCameraSize, data_.num_cameras, 0, 1, kCameraSize},
          {kPointSize, data_.num_points, kCameraSize * data_.num_cameras, 1, kPointSize}};
}

ProblemPart<CpuBackend<double>> BundleParts::Make(int part) {
  const Index begin = first_point_[static_cast<std::size_t>(part)],
              end = first_point_[static_cast<std::size_t>(part) + 1];
  BundleData data;
  data.num_cameras = data_.num_cameras;
  data.num_points = end - begin;
  std::vector<Index> of_part(by_point_.begin() + first_[static_cast<std::size_t>(begin)],
                             by_point_.begin() + first_[static_cast<std::size_t>(end)]);
  std::sort(of_part.begin(), of_part.end());  // the original order
  data.observations.reserve(of_part.size());
  for (const Index k : of_part) {
    Observation observation = data_.observations[static_cast<std::size_t>(k)];
    observation.point -= static_cast<std::int32_t>(begin);
    data.observations.push_back(observation);
  }
  const Index cameras = kCameraSize * data.num_cameras, points = kPointSize * data.num_points;
  data.x.resize(static_cast<std::size_t>(cameras + points));
  // The reduced matrix is the sum over all parts: a part never forms its own.
  BundleProblemOptions options = options_;
  options.reduced_form = ReducedForm::kImplicit;
  options.factorize_reduced = false;
  const std::vector<PartSegment> where{{0, 0, cameras}, {cameras, cameras + kPointSize * begin, points}};
  return {std::make_unique<BundleProblem>(data, options), where, where};
}

}  // namespace vesta::bundle
