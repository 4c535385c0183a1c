// NeRF scenes: transforms.json (instant-ngp, nerfstudio) or transforms_train.json and transforms_test.json (Blender).
#pragma once

#include <cstdint>
#include <string>

#include "problems/gaussian_splatting/model/scene.h"

namespace vesta::gs {

struct RandomPoints {
  Index count = 10000;
  std::uint64_t seed = 0;
};

// Whether the folder holds transforms.json or transforms_train.json.
bool IsNerfScene(const std::string& scene_folder);

// Views, sorted by name, without pixels. Poses are camera to world with OpenGL axes (x right, y up, z backward), turned
// into ours. Intrinsics fl_x, fl_y, cx, cy, w, h, camera_angle_x, camera_angle_y may stand at the top or in a frame;
// where the size is missing it is the image's, where fl_x is missing it follows from the angle, and the principal
// point is the centre by default. A file_path without .png, .jpg or .jpeg gets .png. Distortion: k1, k2, k3, p1, p2 as
// OpenCV has them; with is_fisheye or a fisheye as camera_model k1 to k4 of OpenCV's fisheye.
// Test views: those of transforms_test.json; without that file, every 8th by name.
// Points: the .ply that ply_file_path names, else points3D.ply, points3d.ply or sparse_pc.ply, else `random.count`
// points of random colour, uniform in the cube [-1.3, 1.3]^3 about the origin (as Kerbl et al. 2023 for Blender
// scenes).
// Throws Error, one line with file and frame, for other camera models, k4 of a lens that is no fisheye, poses that are
// not finite or no rotation, unusable intrinsics, invalid JSON, or no frames.
Scene ReadNerfScene(const std::string& scene_folder, const RandomPoints& random);

}  // namespace vesta::gs
