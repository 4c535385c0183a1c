// Of processes that train together, which steps which Gaussians: it alone knows Adam's moments and bases of these.
#pragma once

#include <algorithm>
#include <vector>

#include "kernels/ranks/ranks.h"
#include "problems/gaussian_splatting/adam/adam.h"
#include "problems/gaussian_splatting/train/view_gradient_steps.h"

namespace vesta::gs {

// Each process has a run of chunks of kTurnChunk Gaussians, with about as many numbers of parameters, moments and bases
// as another.
class GaussianOwners {
 public:
  GaussianOwners(const splat::ModelLayout& layout, int processes) : layout_(layout) {
    const Index chunks = (layout.count + kTurnChunk - 1) / kTurnChunk;
    std::vector<Index> numbers{0};  // of the chunks before
    numbers.reserve(static_cast<std::size_t>(chunks + 1));
    for (Index chunk = 0; chunk < chunks; ++chunk) {
      const int attributes = splat::NumAttributes(layout.DegreeOf(chunk * kTurnChunk));
      numbers.push_back(numbers.back() + kBlockNumbers + 3 * attributes);
    }
    for (int r = 0; r <= processes; ++r) {
      const auto at = std::ranges::lower_bound(numbers, numbers.back() * r / processes);
      begin_.push_back(at - numbers.begin());
    }
  }

  int processes() const { return static_cast<int>(begin_.size()) - 1; }
  Share ChunksOf(int process) const {
    const auto r = static_cast<std::size_t>(process);
    return {begin_[r], begin_[r + 1]};
  }
  // The same in Gaussians, and in blocks of terms.
  GaussianRange Of(int process) const { return GaussiansOf(ChunksOf(process)); }
  Share BlocksOf(int process) const {
    const auto block = [](Index gaussian) { return (gaussian + term::kLanes - 1) / term::kLanes; };
    const GaussianRange own = Of(process);
    return {block(own.begin), block(own.end)};
  }
  GaussianRange GaussiansOf(const Share& chunks) const {
    return {std::min(layout_.count, chunks.begin * kTurnChunk), std::min(layout_.count, chunks.end * kTurnChunk)};
  }
  const splat::ModelLayout& layout() const { return layout_; }

 private:
  static_assert(kTurnChunk % term::kLanes == 0);

  splat::ModelLayout layout_;
  std::vector<Index> begin_;  // of each process, in chunks
};

}  // namespace vesta::gs
