// The photographs that a stage is at, in whatever memory it computes.
#pragma once

#include <type_traits>
#include <utility>
#include <vector>

#include "problems/gaussian_splatting/model/targets.h"

namespace vesta::gs {

// Views to fit at one size, with what their truths lie in.
template <class B>
class StageTargets {
 public:
  bool empty() const { return targets_.empty(); }
  const TargetView<B>& operator[](std::size_t i) const { return targets_[i]; }
  const std::vector<TargetView<B>>& all() const { return targets_; }

  // Of photographs that outlive this.
  void Show(const std::vector<const View*>& views, double near) { targets_ = MakeTargets<B>(views, near); }
  // Of photographs made for the purpose.
  void Hold(std::vector<View> views, double near) {
    views_ = std::move(views);
    std::vector<const View*> pointers;
    for (const View& view : views_) pointers.push_back(&view);
    Show(pointers, near);
    if constexpr (!std::is_same_v<typename B::Space, Host>) views_ = std::vector<View>();
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
  // Of views that are held: its photograph has another exposure now.
  void SetPhotograph(std::size_t i, const Image& full) {
    Image& image = views_[i].image;
    image = ResizeArea(full, image.width, image.height);
    targets_[i].truth = SplatBackend<B>::MakeTruth(ValuesOf(image));
    targets_[i].mask = SplatBackend<B>::MakeMask(MaskOf(image));
  }
  void Clear() {
    targets_.clear(), targets_.shrink_to_fit();
    views_ = std::vector<View>();
  }

 private:
  std::vector<View> views_;
  std::vector<TargetView<B>> targets_;
};

}  // namespace vesta::gs
