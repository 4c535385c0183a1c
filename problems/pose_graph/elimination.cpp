#include "problems/pose_graph/elimination.h"

#include <Eigen/OrderingMethods>
#include <Eigen/SparseCore>
#include <algorithm>
#include <utility>

namespace vesta::pose_graph {
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

// Parent of each row in the elimination tree (Liu, 1986), -1 for roots.
std::vector<Index> EliminationTree(const BlockPattern& pattern, const std::vector<Index>& order) {
  const std::vector<Index> position = Inverse(order);
  std::vector<Index> parent(order.size(), -1), ancestor(order.size(), -1);
  for (Index k = 0; k < pattern.num_rows(); ++k) {
    for (const auto& neighbor : pattern.neighbors(order[At(k)])) {
      // Climb to the root of the subtree that holds the neighbour, shortening the path for the next climb.
      for (Index i = position[At(neighbor.row)]; i != -1 && i < k;) {
        const Index next = std::exchange(ancestor[At(i)], k);
        if (next == -1) parent[At(i)] = k;
        i = next;
      }
    }
  }
  return parent;
}

// The same order of elimination up to independent rows, such that each subtree is contiguous.
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
  // Each row is pushed again, marked, below its children; taken then.
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

// Rows below each column of the factor, ascending.
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

// Columns with nested structures become one front; then fronts are joined with their parents where that stores few
// zeros.
std::vector<EliminationFront> JoinColumns(std::vector<std::vector<Index>> below) {
  struct Candidate {
    EliminationFront front;
    double zeros = 0;  // blocks of the panel that hold only zeros
  };
  // Blocks of a panel, its trapezoid.
  const auto panel_blocks = [](Index pivots, Index rows) {
    return 0.5 * static_cast<double>(pivots) * static_cast<double>(2 * rows - pivots + 1);
  };
  std::vector<Candidate> done;
  for (Index k = 0; k < static_cast<Index>(below.size()); ++k) {
    Candidate next;
    next.front.first = k;
    next.front.pivots = 1;
    next.front.below = std::move(below[At(k)]);
    while (!done.empty()) {
      const Candidate& last = done.back();
      const EliminationFront& child = last.front;
      const Index end = next.front.first + next.front.pivots;
      // The front before this one may only be joined when it is a child.
      if (child.below.empty() || child.below.front() >= end) break;
      const Index pivots = child.pivots + next.front.pivots;
      const double total = panel_blocks(pivots, child.pivots + next.front.rows());
      const double held = panel_blocks(child.pivots, child.rows()) - last.zeros +
                          panel_blocks(next.front.pivots, next.front.rows()) - next.zeros;
      const double zeros = total - held;
      const double allowed = pivots <= 4 ? 0.6 : pivots <= 8 ? 0.3 : pivots <= 16 ? 0.1 : 0.05;
      if (zeros > allowed * total) break;
      next.front.first = child.first;
      next.front.pivots = pivots;
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

// Parents, children, and where rows of a front lie in its parent.
void LinkFronts(Index num_rows, std::vector<EliminationFront>* fronts) {
  std::vector<Index> front_of_row(At(num_rows));
  for (std::size_t f = 0; f < fronts->size(); ++f) {
    for (Index k = 0; k < (*fronts)[f].pivots; ++k) front_of_row[At((*fronts)[f].first + k)] = static_cast<Index>(f);
  }
  for (std::size_t f = 0; f < fronts->size(); ++f) {
    EliminationFront& front = (*fronts)[f];
    if (front.below.empty()) continue;
    front.parent = front_of_row[At(front.below.front())];
    EliminationFront& parent = (*fronts)[At(front.parent)];
    parent.children.push_back(static_cast<Index>(f));
    auto place = parent.below.begin();
    for (const Index row : front.below) {
      if (row < parent.first + parent.pivots) {
        front.place_in_parent.push_back(row - parent.first);
      } else {
        place = std::lower_bound(place, parent.below.end(), row);
        front.place_in_parent.push_back(parent.pivots + (place - parent.below.begin()));
      }
    }
  }
}

void PlaceEntries(const BlockPattern& pattern, const std::vector<Index>& order, std::vector<EliminationFront>* fronts) {
  const std::vector<Index> position = Inverse(order);
  for (EliminationFront& front : *fronts) {
    for (Index col = 0; col < front.pivots; ++col) {
      const Index original = order[At(front.first + col)];
      front.entries.push_back({col, col, original, true, false});
      for (const auto& neighbor : pattern.neighbors(original)) {
        const Index row = position[At(neighbor.row)];
        if (row < front.first + col) continue;
        const bool is_pivot = row < front.first + front.pivots;
        const auto below = std::lower_bound(front.below.begin(), front.below.end(), row);
        const Index place = is_pivot ? row - front.first : front.pivots + (below - front.below.begin());
        // Stored blocks have the larger original row.
        front.entries.push_back({place, col, neighbor.block, false, neighbor.row < original});
      }
    }
  }
}

double Multiplications(const EliminationFront& front) {
  const auto rows = static_cast<double>(front.rows()), below = static_cast<double>(front.below.size());
  return (rows * rows * rows - below * below * below) / 6;
}

// Splits the forest until its subtrees are many and small enough for threads to share them evenly.
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
  std::vector<std::size_t> level(plan->fronts.size(), 0);  // one more than the highest level below; 0 inside subtrees
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

}  // namespace

EliminationPlan PlanElimination(const BlockPattern& pattern) {
  EliminationPlan plan;
  plan.order = MinimumDegreeOrder(pattern);
  plan.order = Postorder(plan.order, EliminationTree(pattern, plan.order));
  plan.fronts = JoinColumns(ColumnStructures(pattern, plan.order));
  LinkFronts(pattern.num_rows(), &plan.fronts);
  PlaceEntries(pattern, plan.order, &plan.fronts);
  for (const EliminationFront& front : plan.fronts) {
    plan.factor_blocks += static_cast<double>(front.pivots * (2 * front.rows() - front.pivots + 1)) / 2;
    plan.multiplications += Multiplications(front);
  }
  ChooseSubtrees(&plan);
  return plan;
}

}  // namespace vesta::pose_graph
