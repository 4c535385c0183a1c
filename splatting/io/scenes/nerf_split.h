// SPDX-License-Identifier: Apache-2.0
// The split into training and test views that a transforms.json defines. Internal to the reader of NeRF scenes.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "problems/gaussian_splatting/scene/scene.h"

namespace vesta::gs {

// Applies the lists train_filenames, val_filenames and test_filenames of nerfstudio, which have values of file_path:
// - The views in test_filenames are test views. Without such a list, the views in val_filenames are test views.
// - All other views in train_filenames, or without such a list all views in no list, are training views.
// - The remaining views are removed from the scene.
// Sets Scene::split, and adds a note about removed views. Does nothing if `top` has none of these lists. file: the name
// of the file, for messages. Throws Error if a list is no array of strings, if a list names no view, or if a view is in
// two lists.
void ApplySplitLists(const nlohmann::json& top, const std::string& file, Scene* scene);

// The name of the view with this file_path: the normalized path, plus .png unless it ends in .png, .jpg or .jpeg.
std::string NameOfFilePath(std::string file_path);

}  // namespace vesta::gs
