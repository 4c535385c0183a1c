// SPDX-License-Identifier: Apache-2.0
// The photographs that a stage is at, in whatever memory it computes.
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

// Views to fit at one size, with what their truths lie in. Where the scene's photographs are in a store, the host looks
// at one of them at a time; a device holds its copies of all.
template <class B>
class StageTargets {
 public:
  bool empty() const { return targets_.empty(); }
  std::size_t size() const { return targets_.size(); }
  const splat::PosedCamera& camera(std::size_t i) const { return targets_[i].camera; }
  // The view with its photograph, which is there until another one is asked for.
  const TargetView<B>& operator[](std::size_t i) {
    if (!stored_.empty() && shown_ != i) Look(i);
    return targets_[i];
  }
  // The copies that a device holds; on the host none: the scene's own serve.
  std::span<const TargetView<B>> copies() const {
    return kOnHost ? std::span<const TargetView<B>>() : std::span<const TargetView<B>>(targets_);
  }
  // Whether photographs come out of a store when they are asked for.
  bool are_stored() const { return !stored_.empty(); }
  // The same ahead of time; next() gives the views that will be asked for, one after the other.
  template <class Next>
  void Prefetch(const Next& next) const {
    std::vector<Index> numbers;
    for (Index k = 0; k <= PhotographStore::kAhead; ++k) numbers.push_back(stored_[next()]->number());
    stored_.front()->store()->Expect(numbers);
  }

  // Of photographs that outlive this.
  void Load(const std::vector<const View*>& views, double near) {
    bool are_stored = false;
    for (const View* view : views) are_stored = are_stored || view->stored;
    if (!kOnHost || !are_stored) {
      std::vector<std::shared_ptr<const Image>> kept;  // none: they are copied, or in memory already
      targets_ = MakeTargets<B>(views, near, &kept);
      return;
    }
    for (const View* view : views) {
      targets_.push_back({ToPosedCamera(*view, near), {}, {}});
      stored_.push_back(view->stored);
    }
  }
  // Of photographs made for the purpose.
  void Hold(std::vector<View> views, double near) {
    views_ = std::move(views);
    std::vector<const View*> pointers;
    for (const View& view : views_) pointers.push_back(&view);
    Load(pointers, near);
    if constexpr (!kOnHost) views_ = std::vector<View>();
  }
  // The view's camera is another now. view: of any size.
  void SetCamera(std::size_t i, const View& view) {
    splat::PosedCamera& camera = targets_[i].camera;
    const splat::PosedCamera posed = ToPosedCamera(view, camera.near);
    std::copy_n(posed.R, 9, camera.R);
    std::copy_n(posed.T, 3, camera.T);
    std::copy_n(posed.centre, 3, camera.centre);
    camera.lens = ResizeCamera(view.camera, camera.width, camera.height).lens;
  }
  // Its photograph, of any size, is another now, and its mask where it has one. What is merely looked at is so already.
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
  // Lets go of the photograph that was asked for last, before others are asked for elsewhere: the store's budget has no
  // room for both.
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
  }
  void Look(std::size_t i) {
    Release();  // before the next one takes its room
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
