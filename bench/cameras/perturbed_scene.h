// A scene whose cameras are not where they are said to be, nor its photographs equally exposed.
#pragma once

#include <cstdint>

#include "kernels/gaussian_splatting/camera_motion.h"
#include "problems/gaussian_splatting/model/scene.h"

namespace vesta::bench {

struct Perturbation {
  double degrees = 0;   // that each camera is turned by, about an axis at random
  double centre = 0;    // that its centre is shifted by, in a direction at random; parts of the depth of what it sees
  double exposure = 0;  // gains of training photographs are within 1 -+ this
  double focal = 0;     // that all focal lengths are too long by, parts of themselves
};

// The scene with each view perturbed by itself, the cameras of those of test too. Photographs as they would be with
// more or less light, not clipped. true_gains: of each view.
gs::Scene Perturbed(const gs::Scene& scene, const Perturbation& by, std::uint64_t seed,
                    std::vector<double>* true_gains);

// Where views stand beside where they are in truth, the best similarity of all of them apart.
struct PoseError {
  double degrees = 0;  // median of turns
  double pixels = 0;   // median over the views of the median shift of the scene's points in their images
  double most = 0;     // of the pixels, over the views
  // As pixels, but each view beside its eight nearest alone, their best similarity apart: without slow bends of the
  // whole capture. Smaller for independent errors too, since fewer views share a similarity.
  double near = 0;
};
// found: the training views of `truth`, in its order.
PoseError ErrorOf(const gs::Scene& truth, const std::vector<const gs::View*>& found);

}  // namespace vesta::bench
