// SPDX-License-Identifier: Apache-2.0
#include "bench/training_race/methods.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>

#include "kernels/core/check.h"

namespace vesta::bench {
namespace {

constexpr int kEpochs = 16;  // at least, in the default schedules

std::vector<int> Counts(const Arguments& arguments, const std::string& flag, const std::vector<int>& fallback) {
  const std::vector<std::string> texts = SplitAtCommas(arguments.Flag(flag, ""));
  if (texts.empty()) return fallback;
  std::vector<int> counts;
  counts.reserve(texts.size());
  for (const std::string& text : texts) counts.push_back(ParseCount(flag, text));
  std::sort(counts.begin(), counts.end());
  return counts;
}

std::vector<double> RateFactors(const Arguments& arguments, double ours) {
  std::vector<double> factors;
  for (const std::string& text : SplitAtCommas(arguments.Flag("rate_factors", ""))) {
    char* end = nullptr;
    factors.push_back(std::strtod(text.c_str(), &end));
    if (*end != 0 || !(factors.back() > 0)) Fail(kBadArgument, "--rate_factors={}: choose numbers above 0", text);
  }
  if (factors.empty()) factors = {ours / 2, ours, 2 * ours};
  std::sort(factors.begin(), factors.end());
  return factors;
}

// Adam alone, for comparison: diagonal second moments, and full resolution from the start.
Method AdamMethod(const gs::TrainOptions& ours, int iterations, double factor) {
  Method method{fmt::format("adam {} x{:g}", iterations, factor), MethodKind::kAdam, ours};
  method.options.lm.iterations = 0;
  gs::AdamOptions& adam = method.options.adam;
  adam.second_moment = gs::SecondMoment::kDiagonal;
  adam.half_resolution_until = 0;
  adam.iterations = iterations;
  adam.lr_scale = factor;
  return method;
}

// LM stages are compared by the time to a given cost. So this one runs all iterations with the options that lower the
// cost fastest near a minimum, without options that raise it for better test views.
Method OurLm(const gs::TrainOptions& ours) {
  Method method{"our LM", MethodKind::kOurLm, ours};
  gs::LmStageOptions& lm = method.options.lm;
  lm.function_tolerance = 0;
  lm.gradient_shrinkage = 0;
  lm.initial_lambda = 0.004;
  return method;
}

Method PublishedLm(const gs::TrainOptions& ours, const std::string& preset) {
  Method method{preset, MethodKind::kPublishedLm, ours};
  method.options.lm = gs::PresetOptions(preset).lm;
  return method;
}

}  // namespace

std::vector<Method> SelectMethods(const Arguments& arguments, const gs::TrainOptions& ours, int training_views) {
  const int shortest = std::max(*ours.adam.iterations, kEpochs * training_views);
  const std::vector<int> lengths = Counts(arguments, "lengths", {shortest, 2 * shortest, 4 * shortest});
  const std::vector<double> factors = RateFactors(arguments, ours.adam.lr_scale);
  std::vector<Method> methods;
  for (const std::string& group : SplitAtCommas(arguments.Flag("methods", "ours,paper,adam"))) {
    if (group == "ours") {
      methods.push_back({"ours", MethodKind::kOurs, ours});
    } else if (group == "paper") {
      methods.push_back(OurLm(ours));
      for (const char* preset : {"paper", "paper_code"}) methods.push_back(PublishedLm(ours, preset));
    } else if (group == "adam") {
      bool has_ours = false;
      for (const int length : lengths) {
        for (const double factor : factors) {
          methods.push_back(AdamMethod(ours, length, factor));
          has_ours = has_ours || (length == ours.adam.iterations && factor == ours.adam.lr_scale);
        }
      }
      if (!has_ours) methods.push_back(AdamMethod(ours, *ours.adam.iterations, ours.adam.lr_scale));
    } else {
      Fail(kBadArgument, "--methods={}: choose among ours, paper, adam", group);
    }
  }
  std::stable_sort(methods.begin(), methods.end(), [](const auto& a, const auto& b) { return a.kind < b.kind; });
  if (!methods.empty() && StartsAtLm(methods[0].kind)) {
    Fail(kBadArgument, "--methods: paper starts from the state at which ours begins its LM stage; add ours");
  }
  const int evaluations = arguments.Count("evaluations", 40);
  for (Method& method : methods) method.options.adam.evaluations = evaluations;
  return methods;
}

}  // namespace vesta::bench
