// SPDX-License-Identifier: Apache-2.0
#include "solver/internal/sparse_cholesky/elimination.h"

#include <Eigen/OrderingMethods>
#include <Eigen/SparseCore>
#include <algorithm>
#include <utility>

namespace vesta {
namespace {

std::size_t At(Index i) { return static_cast<std::size_t>(i); }

std::vector<Index> MinimumDegreeOrder(const BlockPattern& pattern) {
  const Index n = pattern.num_rows();
  Eigen::SparseMatrix<double> graph(n, n);
  std::vector<Eigen::Triplet<double>> entries;
  for (Index row = 0; row < n; ++row) {
    entries.emplace_back(static_cast<int>(row), static_cast<int>(row), 1.0);
    for (const auto& neighbor : pattern.neighbors(row)) {
      entries.emplace_back(static_cast<int>(row), static_cast<int>(neighbor.row), 1.0);
    }
  }
  graph.setFromTriplets(entries.begin(), entries.end());
  Eigen::AMDOrdering<int>::PermutationType permutation;
  Eigen::AMDOrdering<int>()(graph, permutation);
  return {permutation.indices().data(), permutation.indices().data() + n};
}

std::vector<Index> Inverse(const std::vector<Index>& order) {
  std::vector<Index> position(order.size());
  for (std::size_t k = 0; k < order.size(); ++k) position[At(order[k])] = static_cast<Index>(k);
  return position;
}

// Parent of each row in the elimination tree (Liu, 1986); -1 for roots.
std::vector<Index> EliminationTree(const BlockPattern& pattern, const std::vector<Index>& order) {
  const std::vector<Index> position = Inverse(order);
  std::vector<Index> parent(order.size(), -1), ancestor(order.size(), -1);
  for (Index k = 0; k < pattern.num_rows(); ++k) {
    for (const auto& neighbor : pattern.neighbors(order[At(k)])) {
      // Climb to the root of the neighbour's subtree, and shorten the path for the next climb.
      for (Index i = position[At(neighbor.row)]; i != -1 && i < k;) {
        const Index next = std::exchange(ancestor[At(i)], k);
        if (next == -1) parent[At(i)] = k;
        i = next;
      }
    }
  }
  return parent;
}

// Reorders independent rows so that each subtree is contiguous.
std::vector<Index> Postorder(const std::vector<Index>& order, const std::vector<Index>& parent) {
  const Index n = static_cast<Index>(order.size());
  std::vector<std::vector<Index>> children(order.size());
  std::vector<Index> stack, result;
  for (Index k = 0; k < n; ++k) {
    if (parent[At(k)] >= 0) children[At(parent[At(k)])].push_back(k);
  }
  for (Index root = n; root-- > 0;) {
    if (parent[At(root)] < 0) stack.push_back(root);
  }
  // Push each row again, marked, below its children. It is taken when reached again.
  while (!stack.empty()) {
    const Index k = stack.back();
    stack.pop_back();
    if (k < 0) {
      result.push_back(order[At(~k)]);
      continue;
    }
    stack.push_back(~k);
    for (auto child = children[At(k)].rbegin(); child != children[At(k)].rend(); ++child) stack.push_back(*child);
  }
  return result;
}

// Rows below the diagonal in each column of the factor, ascending.
std::vector<std::vector<Index>> ColumnStructures(const BlockPattern& pattern, const std::vector<Index>& order) {
  const std::vector<Index> position = Inverse(order);
  std::vector<std::vector<Index>> below(order.size());
  std::vector<Index> mark(order.size(), -1);
  std::vector<std::vector<Index>> children(order.size());
  for (Index k = 0; k < pattern.num_rows(); ++k) {
    std::vector<Index>& rows = below[At(k)];
    const auto add = [&](Index i) {
      if (i > k && std::exchange(mark[At(i)], k) != k) rows.push_back(i);
    };
    for (const auto& neighbor : pattern.neighbors(order[At(k)])) add(position[At(neighbor.row)]);
    for (const Index child : children[At(k)]) {
      for (const Index i : below[At(child)]) add(i);
    }
    std::sort(rows.begin(), rows.end());
    if (!rows.empty()) children[At(rows.front())].push_back(k);
  }
  return below;
}

// The limit that the factor exceeds. Visits the rows of the factor one by one, as subtrees of the elimination tree
// (Liu, 1986), with little memory.
ExceededLimit FindExceeded(const EliminationLimits& limits, const BlockPattern& pattern,
                           const std::vector<Index>& order, const std::vector<Index>& parent) {
  const std::vector<Index> position = Inverse(order);
  std::vector<Index> mark(order.size(), -1);
  std::vector<double> below(order.size(), 0.0);  // scalars below the diagonal of each column of blocks, so far
  double values = 0, multiplications = 0;
  for (Index k = 0; k < pattern.num_rows(); ++k) {
    const double size = pattern.size(order[At(k)]);
    values += 0.5 * size * (size + 1);
    multiplications += size * size * size / 6;
    mark[At(k)] = k;
    for (const auto& neighbor : pattern.neighbors(order[At(k)])) {
      if (position[At(neighbor.row)] > k) continue;
      for (Index i = position[At(neighbor.row)]; mark[At(i)] != k; i = parent[At(i)]) {
        mark[At(i)] = k;
        const double entries = size * pattern.size(order[At(i)]);
        values += entries;
        multiplications += entries * (below[At(i)] + 0.5 * size);
        below[At(i)] += size;
      }
    }
    if (values > limits.factor_values) return ExceededLimit::kFactorValues;
    if (multiplications > limits.multiplications) return ExceededLimit::kMultiplications;
  }
  return ExceededLimit::kNone;
}

// Number of values in the trapezoid of a panel, in scalars.
double PanelValues(Index pivots, Index rows) {
  return 0.5 * static_cast<double>(pivots) * static_cast<double>(2 * rows - pivots + 1);
}

// Merges columns with nested structures into one front, then fronts with their parents if that adds few zeros.
std::vector<EliminationFront> JoinColumns(const std::vector<EliminationPlan::Row>& order,
                                          std::vector<std::vector<Index>> below) {
  struct Candidate {
    EliminationFront front;
    double zeros = 0;  // values of the panel that are always zero
  };
  std::vector<Candidate> done;
  for (Index k = 0; k < static_cast<Index>(below.size()); ++k) {
    Candidate next;
    next.front.first = k;
    next.front.pivots = 1;
    next.front.below = std::move(below[At(k)]);
    next.front.first_scalar = order[At(k)].position;
    next.front.pivot_scalars = next.front.scalars = order[At(k)].size;
    for (const Index row : next.front.below) next.front.scalars += order[At(row)].size;
    while (!done.empty()) {
      const Candidate& last = done.back();
      const EliminationFront& child = last.front;
      // The previous front may be merged only if it is a child.
      if (child.below.empty() || child.below.front() >= next.front.first + next.front.pivots) break;
      const Index pivots = child.pivot_scalars + next.front.pivot_scalars;
      const Index rows = child.pivot_scalars + next.front.scalars;
      const double total = PanelValues(pivots, rows);
      const double held = PanelValues(child.pivot_scalars, child.scalars) - last.zeros +
                          PanelValues(next.front.pivot_scalars, next.front.scalars) - next.zeros;
      const double zeros = total - held;
      const double allowed = pivots <= 12 ? 0.6 : pivots <= 24 ? 0.3 : pivots <= 48 ? 0.1 : 0.05;
      if (zeros > allowed * total) break;
      next.front.first = child.first;
      next.front.pivots += child.pivots;
      next.front.first_scalar = child.first_scalar;
      next.front.pivot_scalars = pivots;
      next.front.scalars = rows;
      next.zeros = zeros;
      done.pop_back();
    }
    done.push_back(std::move(next));
  }
  std::vector<EliminationFront> fronts;
  fronts.reserve(done.size());
  for (Candidate& candidate : done) fronts.push_back(std::move(candidate.front));
  return fronts;
}

// Finds the position of a row of blocks in a front, in scalars.
class FrontPlaces {
 public:
  FrontPlaces(const std::vector<EliminationPlan::Row>& order, const std::vector<EliminationFront>& fronts)
      : order_(order), fronts_(fronts) {
    below_.reserve(fronts.size());
    for (const EliminationFront& front : fronts) {
      std::vector<Index> offsets;
      offsets.reserve(front.below.size());
      Index next = front.pivot_scalars;
      for (const Index row : front.below) {
        offsets.push_back(next);
        next += order[At(row)].size;
      }
      below_.push_back(std::move(offsets));
    }
  }
  Index Of(Index row, Index front) const {
    const EliminationFront& f = fronts_[At(front)];
    if (row < f.first + f.pivots) return order_[At(row)].position - f.first_scalar;
    return below_[At(front)][At(std::lower_bound(f.below.begin(), f.below.end(), row) - f.below.begin())];
  }

 private:
  const std::vector<EliminationPlan::Row>& order_;
  const std::vector<EliminationFront>& fronts_;
  std::vector<std::vector<Index>> below_;
};

// Appends a row of blocks with `size` scalars at position `to`.
void Append(Index size, Index to, std::vector<EliminationFront::Run>* runs) {
  const Index begin = runs->empty() ? 0 : runs->back().end;
  if (!runs->empty() && runs->back().to + begin - runs->back().begin == to) {
    runs->back().end += size;
  } else {
    runs->push_back({begin, begin + size, to});
  }
}

// Sets parents, children, and the positions of a front's rows elsewhere.
void LinkFronts(const std::vector<EliminationPlan::Row>& order, const FrontPlaces& places,
                std::vector<EliminationFront>* fronts) {
  std::vector<Index> front_of_row(order.size());
  for (std::size_t f = 0; f < fronts->size(); ++f) {
    for (Index k = 0; k < (*fronts)[f].pivots; ++k) front_of_row[At((*fronts)[f].first + k)] = static_cast<Index>(f);
  }
  for (std::size_t f = 0; f < fronts->size(); ++f) {
    EliminationFront& front = (*fronts)[f];
    if (front.below.empty()) continue;
    front.parent = front_of_row[At(front.below.front())];
    (*fronts)[At(front.parent)].children.push_back(static_cast<Index>(f));
    for (const Index row : front.below) {
      const auto& [original, source, position, size] = order[At(row)];
      Append(size, position, &front.runs_in_order);
      Append(size, places.Of(row, front.parent), &front.runs_in_parent);
    }
  }
}

void PlaceEntries(const BlockPattern& pattern, const std::vector<Index>& position,
                  const std::vector<EliminationPlan::Row>& order, const FrontPlaces& places,
                  std::vector<EliminationFront>* fronts) {
  for (std::size_t f = 0; f < fronts->size(); ++f) {
    EliminationFront& front = (*fronts)[f];
    for (Index k = front.first; k < front.first + front.pivots; ++k) {
      const auto& [original, source, own_position, size] = order[At(k)];
      const Index col = own_position - front.first_scalar;
      front.entries.push_back({col, col, size, size, original, true, false});
      for (const auto& neighbor : pattern.neighbors(original)) {
        const Index row = position[At(neighbor.row)];
        if (row < k) continue;
        // Stored blocks have the larger original row index first.
        front.entries.push_back({places.Of(row, static_cast<Index>(f)), col, order[At(row)].size, size, neighbor.block,
                                 false, neighbor.row < original});
      }
    }
  }
}

double Multiplications(const EliminationFront& front) {
  const auto rows = static_cast<double>(front.scalars);
  const auto below = static_cast<double>(front.scalars - front.pivot_scalars);
  return (rows * rows * rows - below * below * below) / 6;
}

void ChooseWaves(EliminationPlan* plan) {
  constexpr double kUpdateValues = 0x1p23;  // 64 MiB
  double values = 0;
  for (Index t = 0; t < static_cast<Index>(plan->subtrees.size()); ++t) {
    const EliminationFront& root = plan->fronts[At(plan->subtrees[At(t)].end - 1)];
    const auto below = static_cast<double>(root.scalars - root.pivot_scalars);
    values += below * below;
    if (plan->waves.empty() || values > kUpdateValues) {
      plan->waves.push_back({t, t});
      values = below * below;
    }
    plan->waves.back().end = t + 1;
  }
}

// Splits the forest into subtrees that distribute evenly over threads.
void ChooseSubtrees(EliminationPlan* plan) {
  constexpr double kShare = 1.0 / 32;
  const Index count = static_cast<Index>(plan->fronts.size());
  std::vector<double> work(plan->fronts.size());
  std::vector<Index> begin(plan->fronts.size());
  for (Index f = 0; f < count; ++f) {
    const EliminationFront& front = plan->fronts[At(f)];
    work[At(f)] = Multiplications(front);
    begin[At(f)] = front.children.empty() ? f : begin[At(front.children.front())];
    for (const Index child : front.children) work[At(f)] += work[At(child)];
  }
  const double share = kShare * plan->multiplications;
  std::vector<std::size_t> level(plan->fronts.size(), 0);  // 1 + the highest level of its children; 0 inside subtrees
  for (Index f = 0; f < count; ++f) {
    const EliminationFront& front = plan->fronts[At(f)];
    if (work[At(f)] <= share) {
      if (front.parent < 0 || work[At(front.parent)] > share) plan->subtrees.push_back({begin[At(f)], f + 1});
      continue;
    }
    for (const Index child : front.children) level[At(f)] = std::max(level[At(f)], level[At(child)]);
    if (plan->levels.size() == level[At(f)]) plan->levels.emplace_back();
    plan->levels[level[At(f)]++].push_back(f);
  }
}

// Counts the work, and chooses subtrees, waves and levels.
void ScheduleFronts(EliminationPlan* plan) {
  plan->factor_values = plan->update_values = plan->multiplications = 0;
  for (const EliminationFront& front : plan->fronts) {
    plan->factor_values += PanelValues(front.pivot_scalars, front.scalars);
    const auto below = static_cast<double>(front.scalars - front.pivot_scalars);
    plan->update_values += below * below;
    plan->multiplications += Multiplications(front);
  }
  plan->subtrees.clear();
  plan->waves.clear();
  plan->levels.clear();
  ChooseSubtrees(plan);
  ChooseWaves(plan);
}

}  // namespace

std::optional<EliminationPlan> PlanElimination(const BlockPattern& pattern, const EliminationLimits& limits,
                                               ExceededLimit* exceeded) {
  std::vector<Index> order = MinimumDegreeOrder(pattern);
  order = Postorder(order, EliminationTree(pattern, order));
  const ExceededLimit found = FindExceeded(limits, pattern, order, EliminationTree(pattern, order));
  if (exceeded) *exceeded = found;
  if (found != ExceededLimit::kNone) return std::nullopt;
  EliminationPlan plan;
  for (const Index row : order) {
    plan.order.push_back({row, pattern.offset(row), plan.num_scalars, pattern.size(row)});
    plan.num_scalars += pattern.size(row);
  }
  plan.fronts = JoinColumns(plan.order, ColumnStructures(pattern, order));
  const FrontPlaces places(plan.order, plan.fronts);
  LinkFronts(plan.order, places, &plan.fronts);
  PlaceEntries(pattern, Inverse(order), plan.order, places, &plan.fronts);
  ScheduleFronts(&plan);
  return plan;
}

EliminationPlan Resized(EliminationPlan plan, int from, int to) {
  const auto resize = [&](Index& scalars) { scalars = scalars / from * to; };
  resize(plan.num_scalars);
  for (EliminationPlan::Row& row : plan.order) {
    resize(row.source);
    resize(row.position);
    row.size = to;
  }
  for (EliminationFront& front : plan.fronts) {
    for (Index* scalars : {&front.first_scalar, &front.pivot_scalars, &front.scalars}) resize(*scalars);
    for (std::vector<EliminationFront::Run>* runs : {&front.runs_in_order, &front.runs_in_parent}) {
      for (EliminationFront::Run& run : *runs) {
        for (Index* scalars : {&run.begin, &run.end, &run.to}) resize(*scalars);
      }
    }
    for (EliminationFront::Entry& entry : front.entries) {
      resize(entry.row);
      resize(entry.col);
      entry.rows = entry.cols = to;
    }
  }
  ScheduleFronts(&plan);
  return plan;
}

}  // namespace vesta
