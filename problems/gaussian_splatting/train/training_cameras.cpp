#include "problems/gaussian_splatting/train/training_cameras.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

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
  if (!moved_) return;
  found_.resize(views_.size()), developed_.resize(views_.size());
  for (View* view : own_views_) {
    Image& image = view->image;
    if (FreeBy(options.refine, *view).radial && image.mask.empty()) image.mask.assign(image.num_pixels(), 1);
  }
}

void TrainingCameras::Set(std::size_t view, const ViewUnknowns& found) {
  const View& given = *given_views_[view];
  View& own = *own_views_[view];
  own.rotation = given.rotation, own.translation = given.translation;
  splat::MovePose(found.motion, own.rotation.data(), own.translation.data());
  own.camera.lens = found.lens.Of(given.camera.lens);
  found_[view] = found;
}

bool TrainingCameras::Develop(std::size_t view) {
  if (found_.empty()) return false;
  const View& given = *given_views_[view];
  Image& image = own_views_[view]->image;
  const ViewUnknowns& found = found_[view];
  const Development wanted{found.color, Visible(given.camera, found.lens.radial)};
  if (wanted == developed_[view]) return false;
  // Copied to where they were before, since others look there.
  if (wanted.radial != RadialCoefficients{}) {
    const Image unbent = Unbent(given.image, given.camera, wanted.radial);
    std::ranges::copy(unbent.rgb, image.rgb.begin());
    std::ranges::copy(unbent.mask, image.mask.begin());
  } else {
    std::ranges::copy(given.image.rgb, image.rgb.begin());
    std::ranges::fill(image.mask, std::uint8_t{1});
    std::ranges::copy(given.image.mask, image.mask.begin());
  }
  wanted.color.Inverse().Apply(HostSpan<float>{image.rgb.data(), static_cast<Index>(image.rgb.size())});
  developed_[view] = wanted;
  return true;
}

void TrainingCameras::DevelopAll() {
  for (std::size_t view = 0; view < found_.size(); ++view) Develop(view);
}

double TrainingCameras::CopiedMib() const {
  double bytes = 0;
  if (moved_) {
    for (const View& view : moved_->views) bytes += BytesOf(view.image);
  }
  return bytes / (1 << 20);
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
