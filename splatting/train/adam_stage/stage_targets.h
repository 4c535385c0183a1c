// SPDX-License-Identifier: Apache-2.0
// The views of the Adam stage with their photographs.
#pragma once

#include <algorithm>
#include <limits>
#include <memory>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

#include "problems/gaussian_splatting/model/targets.h"

namespace vesta::gs {

// The training views at one image size, with their photographs: copies of all on a device, references on the host. If
// the photographs are in the scene's store (PhotographStore), the host refers to one photograph at a time.
template <class B>
class StageTargets {
 public:
  bool empty() const { return targets_.empty(); }
  std::size_t size() const { return targets_.size(); }
  const splat::PosedCamera& camera(std::size_t i) const { return targets_[i].camera; }
  // Valid until the next call with another index.
  const TargetView<B>& operator[](std::size_t i) {
    if (!stored_.empty() && shown_ != i) ReadStored(i);
    return targets_[i];
  }
  // The device copies of the photographs; empty on the host.
  std::span<const TargetView<B>> copies() const {
    return kOnHost ? std::span<const TargetView<B>>() : std::span<const TargetView<B>>(targets_);
  }
  // Whether photographs are read from a store on demand.
  bool are_stored() const { return !stored_.empty(); }
  // Starts to read the next photographs from the store. Successive calls of next() return the indices of their views.
  template <class Next>
  void Prefetch(const Next& next) const {
    std::vector<Index> numbers;
    for (Index k = 0; k <= PhotographStore::kAhead; ++k) numbers.push_back(stored_[next()]->number());
    stored_.front()->store()->Expect(numbers);
  }

  // The images of `views` must outlive this object. near: distance of the near plane.
  void Load(const std::vector<const View*>& views, double near) {
    bool are_stored = false;
    for (const View* view : views) are_stored = are_stored || view->stored;
    if (!kOnHost || !are_stored) {
      std::vector<std::shared_ptr<const Image>> kept;  // empty: copied, or in memory already
      targets_ = MakeTargets<B>(views, near, &kept);
      return;
    }
    for (const View* view : views) {
      targets_.push_back({ToPosedCamera(*view, near), {}, {}});
      stored_.push_back(view->stored);
    }
  }
  // The object then owns the images of `views`.
  void LoadOwned(std::vector<View> views, double near) {
    views_ = std::move(views);
    std::vector<const View*> pointers;
    for (const View& view : views_) pointers.push_back(&view);
    Load(pointers, near);
    if constexpr (!kOnHost) views_ = std::vector<View>();
  }
  // Takes the camera of `view`, scaled to the image size of view i.
  void SetCamera(std::size_t i, const View& view) {
    splat::PosedCamera& camera = targets_[i].camera;
    const splat::PosedCamera posed = ToPosedCamera(view, camera.near);
    std::copy_n(posed.R, 9, camera.R);
    std::copy_n(posed.T, 3, camera.T);
    std::copy_n(posed.centre, 3, camera.centre);
    camera.lens = ResizeCamera(view.camera, camera.width, camera.height).lens;
  }
  // Replaces the photograph of view i by `image`, resized if necessary, and the mask if `image` has one. Does nothing
  // on the host for references to the scene's images, which are changed already.
  void SetPhotograph(std::size_t i, const Image& image) {
    if (kOnHost && views_.empty()) return;
    const ImageShape shape = targets_[i].shape();
    const bool fits = image.width == shape.width && image.height == shape.height;
    Image resized;
    if (!fits) resized = ResizeArea(image, shape.width, shape.height);
    if constexpr (kOnHost) {
      if (fits) resized = image;
      views_[i].image = std::move(resized);
      SetTruth(i, views_[i].image);
    } else {
      const Image& shown = fits ? image : resized;
      SplatBackend<B>::CopyTruth(ValuesOf(shown), targets_[i].truth);
      if (!shown.mask.empty()) SplatBackend<B>::CopyMask(MaskOf(shown), targets_[i].mask);
    }
  }
  void Clear() { *this = StageTargets(); }
  // Frees the current photograph of a store. Call before other code reads photographs, because the store's memory limit
  // does not include a second one in use.
  void Release() {
    photograph_.reset();
    shown_ = kNone;
  }

 private:
  static constexpr bool kOnHost = std::is_same_v<typename B::Space, Host>;
  static constexpr std::size_t kNone = std::numeric_limits<std::size_t>::max();

  void SetTruth(std::size_t i, const Image& image) {
    targets_[i].truth = SplatBackend<B>::MakeTruth(ValuesOf(image));
    targets_[i].mask = SplatBackend<B>::MakeMask(MaskOf(image));
    targets_[i].transparency = SplatBackend<B>::MakeTruth(TransparencyOf(image));
  }
  void ReadStored(std::size_t i) {
    Release();  // frees memory for the next one
    photograph_ = stored_[i]->Get();
    SetTruth(i, *photograph_);
    shown_ = i;
  }

  std::vector<View> views_;
  std::vector<TargetView<B>> targets_;
  std::vector<std::shared_ptr<const StoredPhotograph>> stored_;
  std::shared_ptr<const Image> photograph_;  // of view shown_
  std::size_t shown_ = kNone;
};

}  // namespace vesta::gs
