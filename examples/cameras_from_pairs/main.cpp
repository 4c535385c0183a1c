// SPDX-License-Identifier: Apache-2.0
// Bundle adjustment without given poses: from relative rotations and directions of pairs of cameras.
//
//   cameras_from_pairs [FILE] [--outliers=0.1] [--rotation_noise=1] [--direction_noise=2] [--seed=1]
//
// FILE is a problem in the BAL format; without it, a small scene is generated. The poses in the file serve only to
// simulate the pairs and to compute the cost for comparison. Its lenses and observations are used.
//   1. Rotation averaging: rotations of all cameras from rotations of pairs.
//   2. Position averaging: positions of cameras and of some points, from directions.
//   3. Triangulation: all points.
//   4. Bundle adjustment, with and without a robust loss.
// Exit status: 0 if the cost is at most 1.05 times the cost from the poses of the file, 1 if not, 2 for wrong input.
#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "averaging.h"
#include "input.h"
#include "problems/bundle_adjustment/bundle_problem.h"
#include "triangulation.h"

// Reads "--name=value" into the option of this name. False for other arguments.
bool ReadFlag(const std::string& argument, PairOptions& options) {
  struct Flag {
    const char* name;
    double* value;
    double most;
  };
  for (const auto& [name, value, most] : {Flag{"outliers", &options.outliers, 1},
                                          {"rotation_noise", &options.rotation_noise, 180},
                                          {"direction_noise", &options.direction_noise, 180},
                                          {"seed", &options.seed, 1e9}}) {
    const std::string prefix = fmt::format("--{}=", name);
    if (argument.rfind(prefix, 0) != 0) continue;
    const char* text = argument.c_str() + prefix.size();
    char* end = nullptr;
    *value = std::strtod(text, &end);
    VESTA_CHECK(end != text && *end == 0 && *value >= 0 && *value <= most, "{}: choose a number from 0 to {}", argument,
                most);
    return true;
  }
  VESTA_CHECK(argument.rfind('-', 0) != 0,
              "unknown flag {}; there are --outliers, --rotation_noise, --direction_noise and --seed", argument);
  return false;
}

// Directions to points with long tracks, so that each camera sees at least 30 of them. Directions between cameras alone
// do not determine the distances of cameras on a line. Returns the number of nodes, and numbers these points from
// data.num_cameras on.
Index AddPoints(const BundleData& data, const std::vector<View>& views, std::vector<Sight>& sights) {
  std::vector<std::vector<Sight>> tracks(data.num_points);
  for (const Sight& sight : SightsOfPoints(data, views)) tracks[sight.to - data.num_cameras].push_back(sight);
  std::stable_sort(tracks.begin(), tracks.end(), [](const auto& a, const auto& b) { return a.size() > b.size(); });
  std::vector<int> seen(data.num_cameras, 0);
  Index nodes = data.num_cameras;
  for (const std::vector<Sight>& track : tracks) {
    const bool helps = std::any_of(track.begin(), track.end(), [&](const Sight& s) { return seen[s.from] < 30; });
    if (track.size() < 2 || !helps) continue;
    for (const Sight& s : track) {
      sights.push_back({s.from, nodes, s.direction});
      ++seen[s.from];
    }
    ++nodes;
  }
  return nodes;
}

// The lenses and observations of `data`, with poses and points that follow from the pairs.
BundleData StartFromPairs(const BundleData& data, const std::vector<Pair>& pairs) {
  std::vector<View> views = AverageRotations(data.num_cameras, pairs);
  std::vector<Sight> sights;
  for (const Pair& pair : pairs) {
    if (IsCorrect(pair, views)) sights.push_back({pair.from, pair.to, views[pair.from].rotation * pair.direction});
  }
  std::printf("%zu of %zu pairs agree with the averaged rotations\n", sights.size(), pairs.size());
  const Index nodes = AddPoints(data, views, sights);
  std::vector<double> positions = StartPositions(nodes, sights);
  RefinePositions(sights, positions);
  BundleData start = data;
  for (Index i = 0; i < data.num_cameras; ++i) {
    views[i].center = Vector3d::Map(positions.data() + 3 * i);
    SetView(views[i], CameraOf(start, i));
  }
  TriangulateAll(start);
  return start;
}

// Returns the cost. loss: null for least squares.
double Adjust(const char* name, BundleData& data, std::shared_ptr<const vesta::Loss> loss = nullptr) {
  vesta::bundle::BundleProblem problem(data, {.loss = std::move(loss)});
  vesta::LmOptions options = vesta::bundle::BundleLmOptions();
  options.max_iterations = 200;
  const vesta::LmSummary summary = vesta::SolveLm(problem, data.x, options);
  std::printf("%s: %s\n", name, summary.BriefReport().c_str());
  return summary.final_cost;
}

int Run(int argc, char** argv) {
  PairOptions options;
  std::string file;
  for (int i = 1; i < argc; ++i) {
    if (ReadFlag(argv[i], options)) continue;
    VESTA_CHECK(file.empty(), "two files, {} and {}; give one", file, argv[i]);
    file = argv[i];
  }
  BundleData given = file.empty() ? GenerateScene() : vesta::bundle::ReadBal(file);
  BundleData found = StartFromPairs(given, SimulatePairs(given, options));
  // Wrong observations have little influence on these cameras, which then place the points again.
  Adjust("from pairs, robust", found, std::make_shared<vesta::CauchyLoss>(5));
  TriangulateAll(found);
  const double cost = Adjust("from pairs", found);
  const double ratio = cost / Adjust("from the given poses", given);
  std::printf("ratio of the costs: %.4f\n", ratio);
  return ratio <= 1.05 ? 0 : 1;
}

int main(int argc, char** argv) {
  try {
    return Run(argc, argv);
  } catch (const vesta::Error& error) {
    std::fprintf(stderr, "cameras_from_pairs: %s\n", error.what());
    return 2;
  }
}
