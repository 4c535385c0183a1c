// SPDX-License-Identifier: Apache-2.0
// NeRF scenes: transforms.json (instant-ngp, nerfstudio) or transforms_train.json and transforms_test.json (Blender).
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "problems/gaussian_splatting/scene/scene.h"
#include "splatting/points/random_points.h"

namespace vesta::gs {

struct NerfOptions {
  RandomPoints random_points = {};      // for scenes without points
  std::string image_folder = "images";  // replaces images/ at the start of every file_path
  bool allow_missing = false;           // a missing image of unstated size gives a camera of size 0 x 0
  bool follow_split = true;             // apply the lists of file names (ApplySplitLists)
};

// Whether the folder has transforms.json or transforms_train.json.
bool IsNerfScene(const std::string& scene_folder);

// Reads a NeRF scene. The views are sorted by name; their images are not loaded. Poses in the files are camera to world
// with OpenGL axes (x right, y up, z backward); they are converted to vesta's axes.
// Intrinsics are fl_x, fl_y, cx, cy, w, h, camera_angle_x and camera_angle_y, in a frame or at the top level of the
// file. Defaults: w and h from the image, fl_x and fl_y from the angles, fl_y equal to fl_x, and the image centre as
// principal point. Distortion: k1, k2, k3, p1, p2 as in OpenCV. If is_fisheye is true or camera_model is a fisheye: k1
// to k4 of OpenCV's fisheye. mask_path may name the mask of a frame (photographs.h). A file_path without .png, .jpg or
// .jpeg gets .png.
// Test views: the views of transforms_test.json, else test_frames (ScanNet++), else the views in the lists of
// file names (ApplySplitLists, nerf_split.h), else every 8th by name. Frames with is_bad are left out, with a note. The
// points are in the .ply file that ply_file_path names, else points3D.ply, points3d.ply or sparse_pc.ply, else random
// points, with a note (PointsForCameras).
// Throws Error, in one line with file and frame, for other camera models, k4 without a fisheye lens, invalid poses or
// intrinsics, invalid JSON, or no frames.
Scene ReadNerfScene(const std::string& scene_folder, const NerfOptions& options = {});

// The cameras of a transforms.json, or of a camera_path.json of nerfstudio's viewer, in the order and coordinates of
// the file. file_path may be missing or name no file. A frame without intrinsics gets the camera `usual`; a frame with
// a focal length but without w and h gets the size of `usual`. render_width and render_height of a camera path
// replace the size of `usual` (CropCamera). Distortion is ignored. Throws Error as ReadNerfScene.
std::vector<View> ReadNerfCameras(const std::string& file, const Camera& usual);

// Writes a transforms.json for views with pinhole cameras. file_path is the view's name; each frame has its intrinsics.
// Reading the poses back changes at most the last digit or two of a double. more: keys and numbers for the top level.
void WriteNerfCameras(const std::string& file, const std::vector<View>& views,
                      const std::vector<std::pair<std::string, double>>& more = {});

}  // namespace vesta::gs
