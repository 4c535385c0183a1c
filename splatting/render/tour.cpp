#include "splatting/render/tour.h"

#include <algorithm>
#include <limits>
#include <numeric>
#include <utility>

#include "splatting/render/path_through.h"

namespace vesta::gs {
namespace {

using Order = std::vector<std::size_t>;

class Steps {
 public:
  Steps(const std::vector<View>& views, double length_unit) : views_(views), unit_(length_unit) {}
  double operator()(std::size_t a, std::size_t b) const { return StepBetween(views_[a], views_[b], unit_); }
  double Length(const Order& order) const {
    double sum = 0;
    for (std::size_t i = 1; i < order.size(); ++i) sum += (*this)(order[i - 1], order[i]);
    return sum;
  }

 private:
  const std::vector<View>& views_;
  double unit_;
};

Order ToTheNearest(const Steps& step, Order order) {
  for (std::size_t i = 1; i < order.size(); ++i) {
    std::size_t nearest = i;
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t k = i; k < order.size(); ++k) {
      const double length = step(order[i - 1], order[k]);
      if (length < least) least = length, nearest = k;
    }
    std::swap(order[i], order[nearest]);
  }
  return order;
}

// Reverses parts while that makes it shorter (2-opt); the first stays.
void Untangle(const Steps& step, Order& order) {
  constexpr int kMostRounds = 8;
  bool is_better = true;
  for (int round = 0; round < kMostRounds && is_better; ++round) {
    is_better = false;
    for (std::size_t i = 1; i + 1 < order.size(); ++i) {
      for (std::size_t k = i + 1; k < order.size(); ++k) {
        const bool is_last = k + 1 == order.size();
        const double now = step(order[i - 1], order[i]) + (is_last ? 0 : step(order[k], order[k + 1]));
        const double then = step(order[i - 1], order[k]) + (is_last ? 0 : step(order[i], order[k + 1]));
        if (then > now - 1e-9) continue;
        std::reverse(order.begin() + static_cast<std::ptrdiff_t>(i),
                     order.begin() + static_cast<std::ptrdiff_t>(k) + 1);
        is_better = true;
      }
    }
  }
}

}  // namespace

Tour TourOf(const std::vector<View>& views, double length_unit) {
  constexpr double kJumps = 1.5;
  const Steps step(views, length_unit);
  Order given(views.size());
  std::iota(given.begin(), given.end(), std::size_t{0});
  Order other = ToTheNearest(step, given);
  Untangle(step, other);
  if (step.Length(given) <= kJumps * step.Length(other)) return {std::move(given), false};
  return {std::move(other), true};
}

}  // namespace vesta::gs
