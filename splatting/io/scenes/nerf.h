// SPDX-License-Identifier: Apache-2.0
// NeRF scenes: transforms.json (instant-ngp, nerfstudio) or transforms_train.json and transforms_test.json (Blender).
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "problems/gaussian_splatting/scene/scene.h"
#include "splatting/io/scenes/random_points.h"

namespace vesta::gs {

// Whether the folder has transforms.json or transforms_train.json.
bool IsNerfScene(const std::string& scene_folder);

// Views, sorted by name, without pixels. Poses in the files are camera to world with OpenGL axes (x right, y up, z
// backward); they are converted to vesta's axes.
// Intrinsics fl_x, fl_y, cx, cy, w, h, camera_angle_x and camera_angle_y are at the top or in a frame. Defaults: the
// size of the image, fl_x from the angle, and the centre as principal point. Distortion: k1, k2, k3, p1, p2 as in
// OpenCV; with is_fisheye or a fisheye as camera_model, k1 to k4 of OpenCV's fisheye. mask_path may name the mask of a
// frame (photographs.h). A file_path without .png, .jpg or .jpeg gets .png.
// Test views: the views of transforms_test.json; without that file, every 8th by name. Points: the .ply named by
// ply_file_path, else points3D.ply, points3d.ply or sparse_pc.ply, else PointsInCube.
// image_folder: replaces images/, with which all names must then begin. allow_missing: a frame whose image is missing
// gets a camera of 0 x 0 unless the file states its size.
// Throws Error, in one line with file and frame, for other camera models, k4 without a fisheye lens, invalid poses or
// intrinsics, invalid JSON, or no frames.
Scene ReadNerfScene(const std::string& scene_folder, const RandomPoints& random,
                    const std::string& image_folder = "images", bool allow_missing = false);

// The cameras of such a file, in its order and coordinates. Images need not exist or be named. A frame without
// intrinsics gets the camera `usual`; a frame with a focal length but without w and h gets the size of `usual`.
// Distortion is ignored. Throws Error as above.
std::vector<View> ReadNerfCameras(const std::string& file, const Camera& usual);

// Writes such a file for views with pinhole cameras. file_path is the name of the view, and each frame has its
// intrinsics. Reading the poses back changes at most the last digit or two of a double. more: keys and numbers for the
// top level.
void WriteNerfCameras(const std::string& file, const std::vector<View>& views,
                      const std::vector<std::pair<std::string, double>>& more = {});

}  // namespace vesta::gs
