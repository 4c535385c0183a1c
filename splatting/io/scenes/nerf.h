// SPDX-License-Identifier: Apache-2.0
// NeRF scenes: transforms.json (instant-ngp, nerfstudio) or transforms_train.json and transforms_test.json (Blender).
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "problems/gaussian_splatting/scene/scene.h"
#include "splatting/io/scenes/random_points.h"

namespace vesta::gs {

bool IsNerfScene(const std::string& scene_folder);

// The views are sorted by name; their images are not loaded. Poses are camera to world with OpenGL axes (x right, y up,
// z backward), and are converted to vesta's. Intrinsics are fl_x, fl_y, cx, cy, w, h, camera_angle_x and
// camera_angle_y, in a frame or at the top level. Defaults: w and h from the image, fl_x and fl_y from the angles, fl_y
// equal to fl_x, and the image centre as principal point. Distortion: k1, k2, k3, p1, p2 as in OpenCV. If is_fisheye is
// true or camera_model is a fisheye: k1 to k4 of OpenCV's fisheye. mask_path may name the mask of a frame
// (photographs.h). A file_path without .png, .jpg or .jpeg gets .png. Test views: transforms_test.json, else every 8th
// by name. Points: the .ply file in ply_file_path, else points3D.ply, points3d.ply or sparse_pc.ply, else random points
// (PointsInCube). image_folder: unless it is "images", it replaces images/ at the start of every file_path.
// allow_missing: if an image is missing and the file does not state its size, the camera has size 0 x 0. Throws Error,
// with file and frame, for other camera models, k4 without a fisheye lens, invalid poses or intrinsics, invalid JSON,
// or no frames.
Scene ReadNerfScene(const std::string& scene_folder, const RandomPoints& random,
                    const std::string& image_folder = "images", bool allow_missing = false);

// The cameras of such a file, in its order and coordinates, for example as a camera path. file_path may be missing or
// name no file. A frame without intrinsics gets the camera `usual`; a frame with a focal length but without w and h
// gets its size. Distortion is ignored. Throws Error as ReadNerfScene.
std::vector<View> ReadNerfCameras(const std::string& file, const Camera& usual);

// Writes such a file for views with pinhole cameras. file_path is the name of the view; each frame has its intrinsics.
// Reading the poses back changes at most the last digit or two of a double. more: keys and numbers for the top level.
void WriteNerfCameras(const std::string& file, const std::vector<View>& views,
                      const std::vector<std::pair<std::string, double>>& more = {});

}  // namespace vesta::gs
