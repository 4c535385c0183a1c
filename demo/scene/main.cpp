// SPDX-License-Identifier: Apache-2.0
// vesta_demo_scene --out FOLDER: renders the demo as a COLMAP scene.
#include <fmt/format.h>
#include <gflags/gflags.h>

#include <cstdio>
#include <exception>

#include "demo/scene/bent_rays.h"
#include "demo/scene/write_scene.h"
#include "kernels/core/check.h"
#include "kernels/core/parallel.h"

DEFINE_string(out, "", "folder to write the scene to (images/ and sparse/0/); it is created if it does not exist");
DEFINE_int32(views, 40, "number of images");
DEFINE_int32(width, 200, "width of an image in pixels");
DEFINE_int32(height, 150, "height of an image in pixels");
DEFINE_int32(points, 3000, "number of points in the model");
DEFINE_uint64(seed, 0, "seed of the noise in images and points; the scene stays the same");
DEFINE_bool(walk, false, "consecutive images, as in a film of a walk around the scene");
DEFINE_string(lens, "", "lens distortion: k1 or k1,k2 or k1,k2,p1,p2 of COLMAP's SIMPLE_RADIAL, RADIAL, OPENCV");
DEFINE_int32(passer_by_every, 0, "paint a person into every Nth image and write masks/; 0: no person");
DEFINE_int32(threads, 0, "number of threads; 0: one per core");

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
