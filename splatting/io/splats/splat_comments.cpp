// SPDX-License-Identifier: Apache-2.0
#include "splatting/io/splats/splat_comments.h"

#include <cmath>
#include <limits>
#include <string_view>

#include "kernels/core/check.h"
#include "kernels/core/files.h"

namespace vesta::gs {
namespace {

constexpr std::string_view kBackground = "vesta background", kOrigin = "vesta origin", kLowPass = "vesta low_pass";

// The numbers after a comment of that beginning, where there is one; each must be one that is_valid.
template <class T, std::size_t N>
bool ReadComment(const std::string& path, const std::vector<std::string>& comments, std::string_view beginning,
                 const char* what, bool (*is_valid)(double), std::array<T, N>* numbers) {
  bool is_there = false;
  for (std::string_view comment : comments) {
    if (!comment.starts_with(beginning)) continue;
    comment.remove_prefix(beginning.size());
    for (T& number : *numbers) {
      double value = 0;
      if (!ParseNumber(NextWord(&comment), &value) || !is_valid(value)) {
        Fail(kBadFile, "{}: the comment '{}' is not followed by {}; correct or remove it", path, beginning, what);
      }
      number = static_cast<T>(value);
    }
    is_there = true;
  }
  return is_there;
}

}  // namespace

std::vector<std::string> SplatComments(const SplatModel& model) {
  std::vector<std::string> comments;
  const auto& [r, g, b] = model.background;
  const auto& [x, y, z] = model.origin;
  if (model.has_background) comments.push_back(fmt::format("{} {} {} {}", kBackground, r, g, b));
  if (model.origin != std::array<double, 3>{}) comments.push_back(fmt::format("{} {} {} {}", kOrigin, x, y, z));
  VESTA_CHECK(splat::IsLowPass(model.low_pass), "a splat with a low-pass filter of {} pixels^2", model.low_pass);
  if (model.low_pass != splat::kLowPass) comments.push_back(fmt::format("{} {}", kLowPass, model.low_pass));
  return comments;
}

void ReadSplatComments(const std::string& path, const std::vector<std::string>& comments, SplatModel* model) {
  const auto is_color = [](double value) { return value >= 0 && value <= 1; };
  const auto is_place = [](double value) {
    return std::abs(value) <= static_cast<double>(std::numeric_limits<float>::max());
  };
  model->has_background =
      ReadComment(path, comments, kBackground, "three numbers in 0..1", +is_color, &model->background);
  ReadComment(path, comments, kOrigin, "three finite numbers", +is_place, &model->origin);
  std::array<double, 1> low_pass{model->low_pass};
  const std::string what = fmt::format("a number in {}..{}", splat::kLeastLowPass, splat::kMostLowPass);
  ReadComment(path, comments, kLowPass, what.c_str(), &splat::IsLowPass, &low_pass);
  model->low_pass = low_pass[0];
}

}  // namespace vesta::gs
