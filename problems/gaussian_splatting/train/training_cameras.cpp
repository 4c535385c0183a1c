#include "problems/gaussian_splatting/train/training_cameras.h"

#include <algorithm>
#include <cmath>

#include "kernels/core/buffer.h"
#include "kernels/gaussian_splatting/camera_motion.h"

namespace vesta::gs {

TrainingCameras::TrainingCameras(const Scene& given, const CameraOptions& options) : given_(given) {
  if (options.refines()) moved_ = given;
  for (std::size_t i = 0; i < given.views.size(); ++i) {
    if (!given.views[i].is_trained()) continue;
    given_views_.push_back(&given.views[i]);
    if (moved_) own_views_.push_back(&moved_->views[i]);
    views_.push_back(&scene().views[i]);
  }
  if (moved_) found_.resize(views_.size());
}

bool TrainingCameras::Set(std::size_t view, const ViewUnknowns& found) {
  const View& given = *given_views_[view];
  View& own = *own_views_[view];
  own.rotation = given.rotation, own.translation = given.translation;
  splat::MovePose(found.motion, own.rotation.data(), own.translation.data());
  own.camera.lens = found.lens.Of(given.camera.lens);
  const AffineColor &before = found_[view].color, &color = found.color;
  const bool is_exposed_anew = before.gain != color.gain || before.offset != color.offset;
  if (is_exposed_anew) {
    own.image.rgb = given.image.rgb;
    color.Inverse().Apply(HostSpan<float>{own.image.rgb.data(), static_cast<Index>(own.image.rgb.size())});
  }
  found_[view] = found;
  return is_exposed_anew;
}

double TrainingCameras::CopiedMib() const {
  double values = 0;
  if (moved_) {
    for (const View& view : moved_->views) values += static_cast<double>(view.image.rgb.size());
  }
  return values * sizeof(float) / (1 << 20);
}

bool TrainingCameras::Restore(const std::vector<ViewUnknowns>& found) {
  const auto is_sound = [](const ViewUnknowns& view) {
    HostBuffer<double> x(kViewParameters);
    Pack(view, x.view());
    const bool is_finite = std::all_of(x.begin(), x.end(), [](double value) { return std::isfinite(value); });
    return is_finite && view.lens.is_sound() &&
           std::ranges::all_of(view.color.gain, [](double gain) { return gain > 0; });
  };
  if (found.size() != found_.size() || !std::ranges::all_of(found, is_sound)) return false;
  for (std::size_t i = 0; i < found.size(); ++i) Set(i, found[i]);
  return true;
}

}  // namespace vesta::gs
