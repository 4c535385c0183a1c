// SPDX-License-Identifier: Apache-2.0
// NeRF scenes: transforms.json (instant-ngp, nerfstudio) or transforms_train.json and transforms_test.json (Blender).
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "problems/gaussian_splatting/scene/scene.h"
#include "splatting/io/scenes/random_points.h"

namespace vesta::gs {

// Whether the folder holds transforms.json or transforms_train.json.
bool IsNerfScene(const std::string& scene_folder);

// Views, sorted by name, without pixels. Poses are camera to world with OpenGL axes (x right, y up, z backward), turned
// into ours. Intrinsics fl_x, fl_y, cx, cy, w, h, camera_angle_x, camera_angle_y may stand at the top or in a frame;
// where the size is missing it is the image's, where fl_x is missing it follows from the angle, and the principal
// point is the centre by default. mask_path may name the mask of a frame (photographs.h). A file_path without .png,
// .jpg or .jpeg gets .png. Distortion: k1, k2, k3, p1, p2 as OpenCV has them; with is_fisheye or a fisheye as
// camera_model k1 to k4 of OpenCV's fisheye. Test views: those of transforms_test.json; without that file, every 8th by
// name. Points: the .ply that ply_file_path names, else points3D.ply, points3d.ply or sparse_pc.ply, else PointsInCube.
// image_folder: takes the place of images/, with which all names must then begin. allow_missing: a frame whose image is
// missing, where the size of its camera is not stated, has a camera of 0 x 0. Throws Error, one line with file and
// frame, for other camera models, k4 of a lens that is no fisheye, poses that are not finite or no rotation, unusable
// intrinsics, invalid JSON, or no frames.
Scene ReadNerfScene(const std::string& scene_folder, const RandomPoints& random,
                    const std::string& image_folder = "images", bool allow_missing = false);

// The cameras of any such file, in its order and its world; their images need not be there, nor be named. A frame for
// which no intrinsics stand has the camera `usual`, one that states a focal length without w and h its size. Lenses are
// taken for pinholes. Throws Error as above.
std::vector<View> ReadNerfCameras(const std::string& file, const Camera& usual);

// Such a file, of views that are pinholes: file_path is the name, and intrinsics stand in each frame. Poses are read
// back within the last digit or two of a double. `more`, if any, goes to the top: keys and numbers.
void WriteNerfCameras(const std::string& file, const std::vector<View>& views,
                      const std::vector<std::pair<std::string, double>>& more = {});

}  // namespace vesta::gs
