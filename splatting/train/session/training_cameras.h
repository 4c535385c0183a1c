// SPDX-License-Identifier: Apache-2.0
// The current views of a training. During camera refinement, the cameras of the training views move. If exposures are
// refined, the inverse of each found exposure is applied to the photograph, so that all have a common exposure.
#pragma once

#include <optional>
#include <vector>

#include "problems/gaussian_splatting/scene/scene.h"
#include "splatting/cameras/unknowns/view_unknowns.h"

namespace vesta::gs {

class TrainingCameras {
 public:
  // given must outlive this object. It is copied if cameras are refined, including the photographs in memory. If
  // exposures are refined, photographs of a store are loaded into memory too.
  TrainingCameras(const Scene& given, const CameraOptions& options);

  // The scene with the current training views; other views keep their given cameras.
  const Scene& scene() const { return moved_ ? *moved_ : given_; }
  // The training views of scene(); their addresses, and the addresses of their pixels, do not change.
  const std::vector<const View*>& views() const { return views_; }
  // The same views with their given cameras.
  const std::vector<const View*>& given() const { return given_views_; }
  // The unknowns of each training view, relative to its given camera; empty without refinement.
  const std::vector<ViewUnknowns>& found() const { return found_; }
  // Sets the unknowns of a training view and moves its camera. The photograph changes only in Develop.
  void Set(std::size_t view, const ViewUnknowns& found);
  // Recomputes the photograph with the inverse of the found exposure. Returns false if nothing changes.
  bool Develop(std::size_t view);
  void DevelopAll();
  // Memory of the copied photographs, MiB.
  double CopiedMib() const;
  // Restores the unknowns of all training views from a checkpoint. Returns false, and changes nothing, if they are
  // invalid: wrong number of views, values that are not finite or not plausible, a change of a fixed lens or exposure,
  // or different lenses for views that share one.
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
