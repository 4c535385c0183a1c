// SPDX-License-Identifier: Apache-2.0
#include "splatting/train/session/training_cameras.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "kernels/core/buffer.h"
#include "splatting/cameras/unknowns/moved_view.h"

namespace vesta::gs {

TrainingCameras::TrainingCameras(const Scene& given, const CameraOptions& options)
    : given_(given), refined_(options.refine) {
  if (options.refines()) moved_ = given;
  for (std::size_t i = 0; i < given.views.size(); ++i) {
    if (!given.views[i].is_trained()) continue;
    given_views_.push_back(&given.views[i]);
    if (moved_) own_views_.push_back(&moved_->views[i]);
    views_.push_back(&scene().views[i]);
  }
  if (!moved_) return;
  found_.resize(views_.size()), developed_.resize(views_.size());
  if (!FreeBy(options.refine).color) return;  // no exposures, so photographs stay unchanged
  for (View* view : own_views_) {
    if (const auto stored = std::exchange(view->stored, nullptr)) view->image = *stored->Get();
  }
}

void TrainingCameras::Set(std::size_t view, const ViewUnknowns& found) {
  const View& given = *given_views_[view];
  View& own = *own_views_[view];
  const View moved = AsFound(given, found);
  own.rotation = moved.rotation, own.translation = moved.translation, own.camera = moved.camera;
  found_[view] = found;
}

bool TrainingCameras::Develop(std::size_t view) {
  if (found_.empty()) return false;
  const View& given = *given_views_[view];
  Image& image = own_views_[view]->image;
  if (image.empty()) return false;
  const AffineColor& wanted = found_[view].color;
  if (wanted == developed_[view]) return false;
  // Overwrite in place: other objects refer to these values.
  std::ranges::copy(given.Photograph()->rgb, image.rgb.begin());
  wanted.Inverse().Apply(HostSpan<float>{image.rgb.data(), static_cast<Index>(image.rgb.size())});
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
  if (found.size() != found_.size()) return false;
  const FreeUnknowns free = FreeBy(refined_);
  const SharedLenses lenses = LensesSharedBy(given_views_);
  for (std::size_t i = 0; i < found.size(); ++i) {
    const LensChange& lens = found[i].lens;
    HostBuffer<double> x(kViewParameters);
    Pack(found[i], x.view());
    const bool is_finite = std::all_of(x.begin(), x.end(), [](double value) { return std::isfinite(value); });
    if (!is_finite || !lens.is_sound()) return false;
    if (!free.lens && !lens.is_none()) return false;
    if (!free.color && !found[i].color.is_none()) return false;
    if (lens != found[lenses.First(lenses.of[i])].lens) return false;
    constexpr double kRounding = 1e-6;
    const double* const q = found[i].motion.quaternion;
    if (std::abs(std::inner_product(q, q + 4, q, 0.0) - 1) > kRounding) return false;
    if (!std::ranges::all_of(found[i].color.gain, [](double gain) { return gain > 0; })) return false;
  }
  for (std::size_t i = 0; i < found.size(); ++i) Set(i, found[i]);
  return true;
}

}  // namespace vesta::gs
