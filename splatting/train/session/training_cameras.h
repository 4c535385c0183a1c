// SPDX-License-Identifier: Apache-2.0
// The current views of a training. Refinement moves the cameras of the training views, and applies the inverse of each
// found exposure to the photograph, so that all photographs have a common exposure.
#pragma once

#include <optional>
#include <vector>

#include "problems/gaussian_splatting/scene/scene.h"
#include "splatting/cameras/unknowns/view_unknowns.h"

namespace vesta::gs {

class TrainingCameras {
 public:
  // given must outlive this object. If cameras are refined, `given` is copied with the photographs in memory; if
  // exposures are refined, also with the photographs of a store.
  TrainingCameras(const Scene& given, const CameraOptions& options);

  // Has the current training views; other views keep their given cameras.
  const Scene& scene() const { return moved_ ? *moved_ : given_; }
  // The training views of scene(). The addresses of views and pixels do not change.
  const std::vector<const View*>& views() const { return views_; }
  // The same views with their given cameras.
  const std::vector<const View*>& given() const { return given_views_; }
  // Unknowns of each training view, relative to its given camera; empty without refinement.
  const std::vector<ViewUnknowns>& found() const { return found_; }
  // Moves the camera of a training view. The photograph changes only in Develop.
  void Set(std::size_t view, const ViewUnknowns& found);
  // Applies the inverse of the found exposure to the photograph. Returns false if nothing changes.
  bool Develop(std::size_t view);
  void DevelopAll();
  double CopiedMib() const;
  // Restores all training views from a checkpoint. Returns false, and changes nothing, if they are invalid: wrong
  // number of views, values that are not finite or not plausible, a change of a fixed lens or exposure, or different
  // lenses for views that share one.
  bool Restore(const std::vector<ViewUnknowns>& found);

 private:
  const Scene& given_;
  CameraChoice refined_;
  std::optional<Scene> moved_;
  std::vector<const View*> given_views_, views_;
  std::vector<View*> own_views_;
  std::vector<ViewUnknowns> found_;
  std::vector<AffineColor> developed_;  // exposures applied to the photographs
};

}  // namespace vesta::gs
