// SPDX-License-Identifier: Apache-2.0
// vesta_demo_scene --out FOLDER: renders the demo scene and writes it as a COLMAP scene.
#include <fmt/format.h>
#include <gflags/gflags.h>

#include <cstdio>
#include <exception>

#include "demo/scene/bent_rays.h"
#include "demo/scene/write_scene.h"
#include "kernels/core/check.h"
#include "kernels/core/parallel.h"

DEFINE_string(out, "", "folder to write the scene to (images/ and sparse/0/); made where it does not exist");
DEFINE_int32(views, 40, "number of pictures");
DEFINE_int32(width, 200, "width of a picture in pixels");
DEFINE_int32(height, 150, "height of a picture in pixels");
DEFINE_int32(points, 3000, "number of points in the model");
DEFINE_uint64(seed, 0, "other noise in pictures and points, same scene");
DEFINE_bool(walk, false, "pictures one after the other as in a film of somebody who walks round the scene");
DEFINE_string(lens, "", "the lens bends: k1 or k1,k2 or k1,k2,p1,p2 of COLMAP's SIMPLE_RADIAL, RADIAL, OPENCV");
DEFINE_int32(passer_by_every, 0, "somebody is in each Nth picture, and masks/ has where; 0: nobody");
DEFINE_int32(threads, 0, "number of threads; 0: one for each core");

int main(int argc, char** argv) {
  gflags::SetUsageMessage("renders a small scene and writes it in COLMAP's layout\n  vesta_demo_scene --out FOLDER");
  gflags::ParseCommandLineFlags(&argc, &argv, true);
  try {
    if (FLAGS_out.empty() || argc > 1)
      vesta::Fail(vesta::kBadArgument, "give the folder to write to: vesta_demo_scene --out FOLDER");
    if (FLAGS_threads < 0)
      vesta::Fail(vesta::kBadArgument, "--threads={} is out of range; give 0 (one for each core) or more",
                  FLAGS_threads);
    vesta::SetNumThreads(FLAGS_threads);
    vesta::demo::WriteDemoScene({.views = FLAGS_views,
                                 .width = FLAGS_width,
                                 .height = FLAGS_height,
                                 .points = FLAGS_points,
                                 .seed = FLAGS_seed,
                                 .round = FLAGS_walk ? vesta::demo::Round::kWalk : vesta::demo::Round::kRings,
                                 .lens = vesta::demo::ParseLens(FLAGS_lens),
                                 .passer_by_every = FLAGS_passer_by_every},
                                FLAGS_out);
    fmt::print("{}: {} pictures of {} x {}, {} points\n", FLAGS_out, FLAGS_views, FLAGS_width, FLAGS_height,
               FLAGS_points);
    return 0;
  } catch (const std::exception& error) {
    fmt::print(stderr, "vesta_demo_scene: {}\n", error.what());
    return 1;
  }
}
