// The views of a training as they are now: where cameras and exposures are found along with the splat, training views
// move from where they were given, and their photographs are brought to one exposure, and unbent.
#pragma once

#include <map>
#include <optional>
#include <vector>

#include "kernels/ranks/ranks.h"
#include "problems/gaussian_splatting/cameras/options.h"
#include "problems/gaussian_splatting/cameras/unbend.h"
#include "problems/gaussian_splatting/model/scene.h"
#include "problems/gaussian_splatting/train/fit_to_scene.h"

namespace vesta::gs {

class TrainingCameras {
 public:
  // given must outlive this. Where cameras are found along it is copied, photographs and all. Where exposures are,
  // those of a store are in memory then, of `own` of the training views, which this process looks at; where bends of
  // lenses are, photographs have masks.
  TrainingCameras(const Scene& given, const CameraOptions& options, const Share& own);
  TrainingCameras(const Scene& given, const CameraOptions& options)
      : TrainingCameras(given, options, {0, NumTrainingViews(given)}) {}

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
  // Makes the photograph what it is by what was found; false where it is that already, or another
  // process's.
  bool Develop(std::size_t view);
  void DevelopAll();
  // Of photographs that are there twice.
  double CopiedMib() const;
  // All of them, as they were found before; false where that cannot be: not as many, no numbers, what is not found, or
  // other lenses of views that share one.
  bool Restore(const std::vector<ViewUnknowns>& found);

 private:
  // What a photograph was made by.
  struct Development {
    AffineColor color = {};
    RadialCoefficients radial = {};
    bool operator==(const Development&) const = default;
  };

  // Whether radial distortion of its lens is found.
  bool Bends(std::size_t view) const;

  const Scene& given_;
  CameraChoice refined_;
  std::optional<Scene> moved_;
  std::vector<const View*> given_views_, views_;
  std::vector<View*> own_views_;
  std::vector<ViewUnknowns> found_;
  std::vector<Development> developed_;
  std::map<std::size_t, Image> unbent_;  // photographs of lenses whose distortion is found, before their exposure
};

}  // namespace vesta::gs
