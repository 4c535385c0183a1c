// SPDX-License-Identifier: Apache-2.0
#include "splatting/io/splats/palette.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <queue>
#include <utility>

#include "kernels/core/check.h"
#include "kernels/core/parallel.h"

namespace vesta::gs {
namespace {

// Sorted values [begin, end).
struct Interval {
  std::size_t begin, end;
  double mean = 0, spread = 0;  // spread: sum of squared distances from the mean

  Interval(const std::vector<float>& sorted, std::size_t begin_at, std::size_t end_at) : begin(begin_at), end(end_at) {
    for (std::size_t i = begin; i < end; ++i) mean += static_cast<double>(sorted[i]);
    mean /= static_cast<double>(end - begin);
    for (std::size_t i = begin; i < end; ++i) spread += std::pow(static_cast<double>(sorted[i]) - mean, 2);
  }
  bool operator<(const Interval& other) const { return spread < other.spread; }
};

// Index of the first value that is at least `bound`.
std::size_t FirstFrom(const std::vector<float>& sorted, double bound) {
  const auto first = std::partition_point(sorted.begin(), sorted.end(),
                                          [bound](float value) { return static_cast<double>(value) < bound; });
  return static_cast<std::size_t>(first - sorted.begin());
}

// Splits the interval with the greatest spread at its mean until there are `count`. Returns their means in ascending
// order. There must be more than `count` different values.
std::vector<double> MeansOfIntervals(const std::vector<float>& sorted, std::size_t count) {
  std::priority_queue<Interval> intervals;
  intervals.emplace(sorted, 0, sorted.size());
  std::vector<double> means;
  while (intervals.size() + means.size() < count && !intervals.empty()) {
    const Interval widest = intervals.top();
    intervals.pop();
    const std::size_t middle = FirstFrom(sorted, widest.mean);
    if (middle <= widest.begin || middle >= widest.end) {
      means.push_back(widest.mean);  // the values differ by less than rounding
      continue;
    }
    intervals.emplace(sorted, widest.begin, middle);
    intervals.emplace(sorted, middle, widest.end);
  }
  for (; !intervals.empty(); intervals.pop()) means.push_back(intervals.top().mean);
  means.resize(count, means.back());
  std::sort(means.begin(), means.end());
  return means;
}

// Lloyd's algorithm: each entry becomes the mean of the values that are nearest to it. Entries stay in ascending order.
void ImproveEntries(const std::vector<float>& sorted, std::vector<double>* entries) {
  constexpr int kIterations = 40;
  const std::size_t count = entries->size();
  std::vector<std::size_t> first(count + 1);  // of the values of each entry
  first[count] = sorted.size();
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    for (std::size_t e = 1; e < count; ++e) first[e] = FirstFrom(sorted, 0.5 * ((*entries)[e - 1] + (*entries)[e]));
    ParallelFor(static_cast<Index>(count), 16, [&](Index e) {
      const auto at = static_cast<std::size_t>(e);
      if (first[at + 1] > first[at]) (*entries)[at] = Interval(sorted, first[at], first[at + 1]).mean;
    });
  }
}

constexpr Index kMostCells = 256;  // clusters per level of the division

// A part of the vectors: indices in ascending order, and the sum of squared distances from the mean.
struct Cell {
  std::vector<Index> members;
  double spread = 0;
};

class Clustering {
 public:
  Clustering(const std::vector<float>& vectors, Index dimension, Index count)
      : vectors_(vectors.data()), dimension_(dimension) {
    palette_.entries.resize(static_cast<std::size_t>(count * dimension));
    palette_.labels.resize(vectors.size() / static_cast<std::size_t>(dimension));
    std::vector<Index> all(palette_.labels.size());
    std::iota(all.begin(), all.end(), Index{0});
    Divide(all, 0, count);
  }
  VectorPalette& palette() { return palette_; }

 private:
  // Gives these vectors the entries first, first + 1, ...
  void Divide(const std::vector<Index>& members, Index first, Index count) {
    if (members.empty()) return;
    if (static_cast<Index>(members.size()) <= count) {
      for (const Index member : members) SetEntry(first++, {{member}, 0});
      return;
    }
    const bool is_last_level = count <= kMostCells;
    const auto root = static_cast<Index>(std::lround(std::sqrt(static_cast<double>(count))));
    const std::vector<Cell> cells = Cluster(members, is_last_level ? count : std::min(root, kMostCells));
    if (is_last_level) {
      for (const Cell& cell : cells) SetEntry(first++, cell);
      return;
    }
    const std::vector<Index> shares = Shares(cells, count);
    std::vector<Index> firsts(cells.size(), first);
    std::exclusive_scan(shares.begin(), shares.end(), firsts.begin(), first);
    ParallelFor(static_cast<Index>(cells.size()), 1, [&](Index c) {
      const auto at = static_cast<std::size_t>(c);
      Divide(cells[at].members, firsts[at], shares[at]);
    });
  }

  // Divides `count` entries in proportion to the spread of the cells. A cell with vectors gets at least one entry, and
  // at most as many as it has vectors, or half of all entries: this limits the number of levels.
  static std::vector<Index> Shares(const std::vector<Cell>& cells, Index count) {
    double spread = 0;
    Index free = count;
    for (const Cell& cell : cells) spread += cell.spread, free -= cell.members.empty() ? 0 : 1;
    std::vector<Index> shares;
    shares.reserve(cells.size());
    for (const Cell& cell : cells) {
      const auto size = static_cast<Index>(cell.members.size());
      const double part = spread > 0 ? std::min(1.0, cell.spread / spread) : 0.0;
      const auto wanted = static_cast<Index>(std::floor(part * static_cast<double>(free)));
      const Index extra = size == 0 ? 0 : std::min({wanted, size - 1, count / 2 - 1});
      shares.push_back(size == 0 ? 0 : 1 + extra);
      free -= extra;
      spread -= cell.spread;
    }
    return shares;
  }

  // Lloyd's algorithm. Its start values are vectors at equal distances in the list. All iterations but the last use a
  // sample if there are many vectors.
  std::vector<Cell> Cluster(const std::vector<Index>& members, Index count) const {
    constexpr Index kIterations = 8, kSampledPerCell = 64;
    const auto size = static_cast<Index>(members.size());
    std::vector<Cell> cells(static_cast<std::size_t>(count));
    for (Index c = 0; c < count; ++c) {
      cells[static_cast<std::size_t>(c)].members = {
          members[static_cast<std::size_t>((2 * c + 1) * size / (2 * count))]};
    }
    const Index stride = std::max<Index>(1, size / (kSampledPerCell * count));
    std::vector<Index> sample;
    sample.reserve(static_cast<std::size_t>(size / stride + 1));
    for (Index i = 0; i < size; i += stride) sample.push_back(members[static_cast<std::size_t>(i)]);
    std::vector<float> centres(static_cast<std::size_t>(count * dimension_));
    for (Index iteration = 0; iteration < kIterations; ++iteration) {
      ParallelFor(count, 1, [&](Index c) { SetCentre(c, &cells[static_cast<std::size_t>(c)], &centres); });
      Assign(centres, iteration + 1 < kIterations ? sample : members, &cells);
    }
    ParallelFor(count, 1, [&](Index c) { SetCentre(c, &cells[static_cast<std::size_t>(c)], &centres); });
    return cells;
  }

  // A cell without vectors keeps its centre.
  void SetCentre(Index c, Cell* cell, std::vector<float>* centres) const {
    cell->spread = 0;
    if (cell->members.empty()) return;
    const std::vector<double> mean = Mean(cell->members);
    std::transform(mean.begin(), mean.end(), centres->begin() + c * dimension_,
                   [](double value) { return static_cast<float>(value); });
    for (const Index member : cell->members) {
      for (Index k = 0; k < dimension_; ++k) {
        const double difference = Value(member, k) - mean[static_cast<std::size_t>(k)];
        cell->spread += difference * difference;
      }
    }
  }

  // Moves each of these vectors to the cell with the nearest centre.
  void Assign(const std::vector<float>& centres, const std::vector<Index>& members, std::vector<Cell>* cells) const {
    constexpr std::size_t kBlock = 16;
    const std::size_t count = cells->size(), blocks = (count + kBlock - 1) / kBlock;
    const auto dimension = static_cast<std::size_t>(dimension_);
    // The nearest centre c has the greatest x'c - c'c / 2. Blocks of centres are transposed, so that the inner loop is
    // over centres. Padding is never nearest.
    std::vector<float> transposed(blocks * dimension * kBlock), offsets(blocks * kBlock, -HUGE_VALF);
    for (std::size_t c = 0; c < count; ++c) {
      double square = 0;
      for (std::size_t k = 0; k < dimension; ++k) {
        const float value = centres[c * dimension + k];
        transposed[((c / kBlock) * dimension + k) * kBlock + c % kBlock] = value;
        square += static_cast<double>(value) * static_cast<double>(value);
      }
      offsets[c] = static_cast<float>(-0.5 * square);
    }
    std::vector<std::uint32_t> nearest(members.size());
    ParallelForChunks(static_cast<Index>(members.size()), 256, [&](Index begin, Index end) {
      for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i) {
        const float* vector = vectors_ + members[i] * dimension_;
        float best = -HUGE_VALF;
        for (std::size_t block = 0; block < blocks; ++block) {
          std::array<float, kBlock> scores;
          std::copy_n(offsets.begin() + static_cast<std::ptrdiff_t>(block * kBlock), kBlock, scores.begin());
          const float* centre = transposed.data() + block * dimension * kBlock;
          for (std::size_t k = 0; k < dimension; ++k, centre += kBlock) {
            for (std::size_t j = 0; j < kBlock; ++j) scores[j] += vector[k] * centre[j];
          }
          for (std::size_t j = 0; j < kBlock; ++j) {
            if (scores[j] > best) best = scores[j], nearest[i] = static_cast<std::uint32_t>(block * kBlock + j);
          }
        }
      }
    });
    for (Cell& cell : *cells) cell.members.clear();
    for (std::size_t i = 0; i < members.size(); ++i) (*cells)[nearest[i]].members.push_back(members[i]);
  }

  void SetEntry(Index entry, const Cell& cell) {
    if (cell.members.empty()) return;
    const std::vector<double> mean = Mean(cell.members);
    std::transform(mean.begin(), mean.end(), palette_.entries.begin() + entry * dimension_,
                   [](double value) { return static_cast<float>(value); });
    for (const Index member : cell.members) {
      palette_.labels[static_cast<std::size_t>(member)] = static_cast<std::uint16_t>(entry);
    }
  }

  std::vector<double> Mean(const std::vector<Index>& members) const {
    std::vector<double> mean(static_cast<std::size_t>(dimension_));
    for (const Index member : members) {
      for (Index k = 0; k < dimension_; ++k) mean[static_cast<std::size_t>(k)] += Value(member, k);
    }
    for (double& value : mean) value /= static_cast<double>(members.size());
    return mean;
  }

  double Value(Index vector, Index k) const { return static_cast<double>(vectors_[vector * dimension_ + k]); }

  const float* vectors_;
  Index dimension_;
  VectorPalette palette_;
};

}  // namespace

NumberPalette MakeNumberPalette(std::vector<float> values) {
  VESTA_CHECK(!values.empty(), "a palette for no values");
  std::sort(values.begin(), values.end());
  NumberPalette palette;
  std::vector<float> different;
  different.reserve(palette.size() + 1);
  for (const float value : values) {
    if (different.empty() || value != different.back()) different.push_back(value);
    if (different.size() > palette.size()) break;
  }
  if (different.size() <= palette.size()) {
    palette.fill(different.back());
    std::copy(different.begin(), different.end(), palette.begin());
    return palette;
  }
  std::vector<double> entries = MeansOfIntervals(values, palette.size());
  ImproveEntries(values, &entries);
  std::transform(entries.begin(), entries.end(), palette.begin(),
                 [](double entry) { return static_cast<float>(entry); });
  if (std::binary_search(values.begin(), values.end(), 0.0f)) palette[NearestEntry(palette, 0)] = 0;
  return palette;
}

std::uint8_t NearestEntry(const NumberPalette& palette, float value) {
  const auto above = std::lower_bound(palette.begin(), palette.end(), value);
  if (above == palette.begin()) return 0;
  const auto below = above - 1;
  const bool is_above = above != palette.end() && *above - value < value - *below;
  return static_cast<std::uint8_t>((is_above ? above : below) - palette.begin());
}

VectorPalette MakeVectorPalette(const std::vector<float>& vectors, Index dimension, Index count) {
  VESTA_CHECK(count >= 1 && count <= 65536, "a palette of {} entries", count);
  return std::move(Clustering(vectors, dimension, count).palette());
}

}  // namespace vesta::gs
