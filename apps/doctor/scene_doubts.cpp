// SPDX-License-Identifier: Apache-2.0
#include "apps/doctor/scene_doubts.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "apps/doctor/view_signs.h"
#include "problems/gaussian_splatting/scene/scene.h"

namespace vesta::app {
namespace {

// Thresholds: from these on something is worth a look.
constexpr Index kFewViews = 10, kFewPoints = 500, kFewSeen = 20;
constexpr double kSameThumbnail = 1.0 / 255;  // mean difference
constexpr double kBlurred = 0.25;             // sharpness, by the median of the views
constexpr double kStops = 0.6;                // of exposure, beside the median view
constexpr double kBurnt = 0.2;                // of the pixels
constexpr double kFlat = 2.0 / 255;           // contrast
constexpr Index kSample = 20000;              // of the points, where there are more

// Lines about single views, of which the first few are told.
class Findings {
 public:
  void Add(std::string line) { lines_.push_back(std::move(line)); }
  void AppendTo(std::vector<std::string>* doubts, const char* more) {
    constexpr std::size_t kMost = 5;
    const std::size_t rest = lines_.size() > kMost ? lines_.size() - kMost : 0;
    lines_.resize(std::min(lines_.size(), kMost));
    doubts->insert(doubts->end(), lines_.begin(), lines_.end());
    if (rest > 0) doubts->push_back(fmt::format("and {} more {}", rest, more));
  }

 private:
  std::vector<std::string> lines_;
};

void DoubtNumbers(const gs::Scene& scene, std::vector<std::string>* doubts) {
  const auto views = static_cast<Index>(scene.views.size());
  if (views < kFewViews) doubts->push_back(fmt::format("{} views are few: more of them, all round, help most", views));
  if (scene.points.size() < kFewPoints) {
    doubts->push_back(
        fmt::format("{} points are few to start from: did the reconstruction find the scene?", scene.points.size()));
  }
}

void DoubtSeen(const gs::Scene& scene, std::vector<std::string>* doubts) {
  Findings findings;
  const Index stride = std::max<Index>(1, scene.points.size() / kSample);
  for (const gs::View& view : scene.views) {
    Index seen = 0;
    for (Index i = 0; i < scene.points.size(); i += stride) {
      if (gs::DepthInView(view, scene.points.positions[static_cast<std::size_t>(i)]) > 0) seen += stride;
    }
    if (seen < kFewSeen) findings.Add(fmt::format("{}: sees {} of the points: is its pose right?", view.name, seen));
  }
  findings.AppendTo(doubts, "views that see few points");
}

void DoubtSame(const gs::Scene& scene, const std::vector<ViewSigns>& signs, std::vector<std::string>* doubts) {
  Findings findings;
  for (std::size_t i = 0; i < signs.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      if (ThumbnailDistance(signs[i], signs[j]) >= kSameThumbnail) continue;
      findings.Add(fmt::format("{}: nearly the same photograph as {}", scene.views[i].name, scene.views[j].name));
      break;  // one is enough
    }
  }
  findings.AppendTo(doubts, "photographs that are nearly the same as another");
}

void DoubtPoses(const gs::Scene& scene, std::vector<std::string>* doubts) {
  constexpr double kNear = 1e-6;
  Findings findings;
  for (std::size_t i = 0; i < scene.views.size(); ++i) {
    const gs::View& view = scene.views[i];
    const auto center = gs::CameraCenter(view);
    for (std::size_t j = 0; j < i; ++j) {
      const auto other = gs::CameraCenter(scene.views[j]);
      double distance = 0, turn = 0;
      for (std::size_t k = 0; k < 3; ++k) distance = std::max(distance, std::abs(center[k] - other[k]));
      for (std::size_t k = 0; k < 9; ++k)
        turn = std::max(turn, std::abs(view.rotation[k] - scene.views[j].rotation[k]));
      if (distance > kNear * scene.extent || turn > kNear) continue;
      findings.Add(fmt::format("{}: has the pose of {}", view.name, scene.views[j].name));
      break;
    }
  }
  findings.AppendTo(doubts, "views with the pose of another");
}

void DoubtPhotographs(const gs::Scene& scene, const std::vector<ViewSigns>& signs, std::vector<std::string>* doubts) {
  std::vector<double> sharpness;
  sharpness.reserve(signs.size());
  for (const ViewSigns& sign : signs) sharpness.push_back(sign.sharpness);
  const double usual_sharpness = gs::Median(std::move(sharpness));
  const std::vector<double> stops_of = ExposureStops(scene);
  Findings flat, blurred, exposed, burnt;
  for (std::size_t i = 0; i < signs.size(); ++i) {
    const ViewSigns& sign = signs[i];
    const std::string& name = scene.views[i].name;
    const double stops = stops_of[i];
    if (sign.contrast < kFlat) {
      flat.Add(fmt::format("{}: of one colour", name));
      continue;
    }
    if (sign.sharpness < kBlurred * usual_sharpness) {
      blurred.Add(fmt::format("{}: blurred? It has {:.0f} % of the usual sharpness", name,
                              100 * sign.sharpness / usual_sharpness));
    }
    if (std::abs(stops) > kStops) {
      exposed.Add(
          fmt::format("{}: {:.1f} stops {} than the others", name, std::abs(stops), stops < 0 ? "darker" : "lighter"));
    }
    if (sign.burnt > kBurnt) {
      burnt.Add(fmt::format("{}: {:.0f} % of its pixels are at the top of a channel", name, 100 * sign.burnt));
    }
  }
  flat.AppendTo(doubts, "photographs of one colour");
  blurred.AppendTo(doubts, "photographs that may be blurred");
  exposed.AppendTo(doubts, "photographs of another exposure");
  burnt.AppendTo(doubts, "photographs with much at the top of a channel");
}

}  // namespace

std::vector<std::string> SceneDoubts(const gs::Scene& scene) {
  std::vector<std::string> doubts;
  if (scene.views.empty()) return doubts;
  std::vector<ViewSigns> signs;
  signs.reserve(scene.views.size());
  for (const gs::View& view : scene.views) signs.push_back(SignsOf(*view.Photograph()));
  DoubtNumbers(scene, &doubts);
  DoubtSeen(scene, &doubts);
  DoubtPoses(scene, &doubts);
  DoubtSame(scene, signs, &doubts);
  DoubtPhotographs(scene, signs, &doubts);
  return doubts;
}

}  // namespace vesta::app
