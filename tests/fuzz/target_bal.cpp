// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <iterator>

#include "problems/bundle_adjustment/bal_file.h"
#include "tests/fuzz/promise.h"
#include "tests/fuzz/scratch_folder.h"
#include "tests/fuzz/targets.h"

namespace vesta::fuzz {
namespace {

void PromiseBundle(const bundle::BundleData& data) {
  const auto numbers = static_cast<std::size_t>(9 * data.num_cameras + 3 * data.num_points);
  Promise(data.num_cameras >= 0 && data.num_points >= 0 && data.x.size() == numbers, "a wrong number of parameters");
  for (const bundle::Observation& o : data.observations) {
    Promise(o.camera >= 0 && o.camera < data.num_cameras, "an observation by an unknown camera");
    Promise(o.point >= 0 && o.point < data.num_points, "an observation of an unknown point");
    Promise(std::isfinite(o.pixel[0]) && std::isfinite(o.pixel[1]), "a pixel that is not finite");
  }
  for (const double value : data.x) Promise(std::isfinite(value), "a parameter that is not finite");
}

bool Same(const bundle::BundleData& a, const bundle::BundleData& b) {
  const auto same = [](const bundle::Observation& o, const bundle::Observation& p) {
    return o.camera == p.camera && o.point == p.point &&
           std::equal(std::begin(o.pixel), std::end(o.pixel), std::begin(p.pixel));
  };
  return std::equal(a.observations.begin(), a.observations.end(), b.observations.begin(), b.observations.end(), same) &&
         std::equal(a.x.begin(), a.x.end(), b.x.begin(), b.x.end());
}

}  // namespace

void FuzzBal(std::string_view bytes) {
  static const ScratchFolder folder;
  const std::string path = folder.Write("problem.txt", bytes), copy = folder / "copy.txt";
  bundle::BundleData data;
  if (!Reads(path, [&] { data = bundle::ReadBal(path); })) return;
  PromiseBundle(data);
  bundle::WriteBal(copy, data);
  Promise(Same(data, bundle::ReadBal(copy)), "writing and reading changes the problem");
}

}  // namespace vesta::fuzz
