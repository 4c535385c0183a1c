// SPDX-License-Identifier: Apache-2.0
#include "problems/gaussian_splatting/model/splat_model.h"

#include <algorithm>
#include <array>
#include <numeric>
#include <utility>

#include "kernels/core/check.h"
#include "kernels/core/parallel.h"
#include "problems/gaussian_splatting/model/gather_rows.h"

namespace vesta::gs {

std::vector<Index> GaussiansWithin(const SplatModel& model, const Box& box) {
  std::vector<Index> within;
  for (Index i = 0; i < model.count; ++i) {
    bool is_within = true;
    for (std::size_t k = 0; k < 3; ++k) {
      const float* means = model.attribute(splat::kMean + static_cast<int>(k));
      const double at = static_cast<double>(means[i]) + model.origin[k];
      is_within = is_within && at >= box.low[k] && at <= box.high[k];
    }
    if (is_within) within.push_back(i);
  }
  return within;
}

SplatModel TakeGaussians(SplatModel model, const DegreeOrder& order) {
  std::vector<float> data(static_cast<std::size_t>(order.layout.Size()));
  GatherGaussians<Host>(model, order.layout, order.source.data(), nullptr, model.data.data(), data.data());
  static_cast<splat::ModelLayout&>(model) = order.layout;
  model.data = std::move(data);
  return model;
}

DegreeOrder OrderByDegree(const splat::ModelLayout& layout, const std::vector<std::uint8_t>& degrees) {
  VESTA_CHECK(static_cast<Index>(degrees.size()) == layout.count, "{} degrees do not match {} Gaussians",
              degrees.size(), layout.count);
  std::int64_t with_band[splat::kMaxShDegree + 1] = {};
  for (std::size_t i = 0; i < degrees.size(); ++i) {
    const int most = layout.DegreeOf(static_cast<Index>(i));
    VESTA_CHECK(degrees[i] <= most, "degree {} for Gaussian {} exceeds its present degree {}", degrees[i], i, most);
    for (int band = 0; band <= degrees[i]; ++band) ++with_band[band];
  }
  DegreeOrder order{std::vector<std::uint32_t>(degrees.size()), splat::LayoutOfBands(with_band)};
  std::iota(order.source.begin(), order.source.end(), 0u);
  std::ranges::stable_sort(order.source, [&](std::uint32_t a, std::uint32_t b) { return degrees[a] > degrees[b]; });
  return order;
}

splat::ModelLayout LayoutOfRows(const splat::ModelLayout& layout, const std::vector<std::uint32_t>& source) {
  std::int64_t with_band[splat::kMaxShDegree + 1] = {};
  for (int band = 0; band <= splat::kMaxShDegree; ++band) {
    const auto has_band = [&](std::uint32_t i) { return i < layout.WithBand(band); };
    const auto end = std::ranges::find_if_not(source, has_band);
    VESTA_CHECK(std::none_of(end, source.end(), has_band), "Gaussians are not in the order of their degrees");
    with_band[band] = end - source.begin();
  }
  return splat::LayoutOfBands(with_band);
}

SplatModel AtOneDegree(SplatModel model) {
  if (model.is_uniform()) return model;
  DegreeOrder same{std::vector<std::uint32_t>(static_cast<std::size_t>(model.count)),
                   {.count = model.count, .sh_degree = model.sh_degree}};
  std::iota(same.source.begin(), same.source.end(), 0u);
  return TakeGaussians(std::move(model), same);
}

std::vector<std::uint8_t> StoredDegrees(const SplatModel& model) {
  const auto n = static_cast<std::size_t>(model.count);
  std::vector<std::uint8_t> degrees(n), present(n);
  for (Index i = 0; i < model.count; ++i) {
    present[static_cast<std::size_t>(i)] = static_cast<std::uint8_t>(model.DegreeOf(i));
  }
  for (int band = 1; band <= model.sh_degree; ++band) {
    std::vector<char> has_band(n);
    ParallelForChunks(model.WithBand(band), 4096, [&](Index begin, Index end) {
      for (int a = splat::FirstOfBand(band); a < splat::NumAttributes(band); ++a) {
        const float* values = model.attribute(a);
        for (Index i = begin; i < end; ++i) {
          if (values[i] != 0) has_band[static_cast<std::size_t>(i)] = true;
        }
      }
    });
    bool is_trained = false;
    for (std::size_t i = 0; i < n; ++i) {
      if (has_band[i]) degrees[i] = static_cast<std::uint8_t>(band), is_trained = true;
    }
    if (!is_trained) return present;
  }
  return degrees;
}

SplatModel AtStoredDegrees(SplatModel model) {
  const DegreeOrder order = OrderByDegree(model, StoredDegrees(model));
  return order.layout == model.layout() ? model : TakeGaussians(std::move(model), order);
}

}  // namespace vesta::gs
