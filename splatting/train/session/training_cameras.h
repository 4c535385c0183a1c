// SPDX-License-Identifier: Apache-2.0
// The current views of a training. With camera refinement, training views move away from their given cameras, and their
// photographs are brought to a common exposure.
#pragma once

#include <optional>
#include <vector>

#include "problems/gaussian_splatting/scene/scene.h"
#include "splatting/cameras/unknowns/view_unknowns.h"

namespace vesta::gs {

class TrainingCameras {
 public:
  // given must outlive this object. With camera refinement it is copied, including photographs. With exposure
  // refinement, stored photographs are loaded into memory.
  TrainingCameras(const Scene& given, const CameraOptions& options);

  // The scene with the current training views; other views keep their given cameras.
  const Scene& scene() const { return moved_ ? *moved_ : given_; }
  // The training views of scene(); their addresses, and the addresses of their pixels, do not change.
  const std::vector<const View*>& views() const { return views_; }
  // The same views with their given cameras.
  const std::vector<const View*>& given() const { return given_views_; }
  // The unknowns of each training view, relative to its given camera; empty without refinement.
  const std::vector<ViewUnknowns>& found() const { return found_; }
  // Sets the camera at once; the photograph changes only in Develop.
  void Set(std::size_t view, const ViewUnknowns& found);
  // Applies the found exposure to the photograph; returns false if it already has it.
  bool Develop(std::size_t view);
  void DevelopAll();
  // Memory of the copied photographs.
  double CopiedMib() const;
  // Restores the unknowns of all views from a checkpoint. Returns false if they are invalid: wrong count, not finite, a
  // fixed unknown changed, or different lenses for views that share one.
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
