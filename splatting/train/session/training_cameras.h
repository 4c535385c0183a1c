// SPDX-License-Identifier: Apache-2.0
// The views of a training as they are now: where cameras and exposures are found along with the splat, training views
// move from where they were given, and their photographs are brought to one exposure.
#pragma once

#include <optional>
#include <vector>

#include "problems/gaussian_splatting/scene/scene.h"
#include "splatting/cameras/unknowns/view_unknowns.h"

namespace vesta::gs {

class TrainingCameras {
 public:
  // given must outlive this. Where cameras are found along it is copied, photographs and all. Where exposures are,
  // those of a store are in memory then.
  TrainingCameras(const Scene& given, const CameraOptions& options);

  // The scene with the training views as they are now; the others are as they were given.
  const Scene& scene() const { return moved_ ? *moved_ : given_; }
  // Its training views; they and the values of their photographs stay where they lie in memory.
  const std::vector<const View*>& views() const { return views_; }
  // The same as they were given.
  const std::vector<const View*>& given() const { return given_views_; }
  // Of each of them, from as it was given; empty where nothing is found along.
  const std::vector<ViewUnknowns>& found() const { return found_; }
  // Its camera is there at once, its photograph when it is developed.
  void Set(std::size_t view, const ViewUnknowns& found);
  // Makes the photograph what it is by what was found; false where it is that already.
  bool Develop(std::size_t view);
  void DevelopAll();
  // Of photographs that are there twice.
  double CopiedMib() const;
  // All of them, as they were found before; false where that cannot be: not as many, no numbers, what is not found, or
  // other lenses of views that share one.
  bool Restore(const std::vector<ViewUnknowns>& found);

 private:
  const Scene& given_;
  CameraChoice refined_;
  std::optional<Scene> moved_;
  std::vector<const View*> given_views_, views_;
  std::vector<View*> own_views_;
  std::vector<ViewUnknowns> found_;
  std::vector<AffineColor> developed_;  // what photographs were made by
};

}  // namespace vesta::gs
