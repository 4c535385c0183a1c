// A model seen by the views that judge it, and what they make of it.
#pragma once

#include <memory>

#include "kernels/gaussian_splatting/splat_view.h"
#include "kernels/image/gaussian_window.h"
#include "kernels/image/photometric_loss.h"
#include "problems/gaussian_splatting/model/masked_loss.h"
#include "problems/gaussian_splatting/model/targets.h"
#include "problems/gaussian_splatting/model/to_kernel.h"
#include "problems/gaussian_splatting/parsimony/judging_views.h"

namespace vesta::gs {

// Bytes of both of them for such a model and its largest view, with what they sum up by pair and splat; the passes over
// single Gaussians besides.
inline double JudgingBytes(const splat::ViewCounts& view, double gaussians) {
  using Workspace = splat::ViewWorkspace<float>;
  constexpr double kSums = sizeof(splat::RecolorRises<float>),
                   kImages = 2 + LinearizationImages(SsimLinearization::kQuadratic);
  return splat::SplatView<float>::Bytes(view, gaussians) + Workspace::BuildBytes(view, gaussians) +
         splat::kSpareRoom * (view.splats + view.pairs) * kSums + view.splats * sizeof(splat::Recolors<float>) +
         kImages * 3 * sizeof(float) * view.pixels +
         PhotometricLoss<float>::GradientBytes(SsimLinearization::kQuadratic, view.pixels);
}

// Renders the model into one judge after the other.
class RenderedViews {
 public:
  // Both must outlive this.
  RenderedViews(const splat::Model<float>& model, const JudgingViews& judges) : model_(model), judges_(judges) {}

  // body(view): with view() and image() of that judge.
  template <class Body>
  void ForEach(const Body& body) {
    for (const View* view : judges_.views) {
      image_.ResizeForOverwrite(ImageShape{view->camera.width, view->camera.height}.NumValues());
      view_.Build(model_, ToPosedCamera(*view, judges_.near), judges_.background.data(), workspace_);
      view_.Render(image_.data());
      body(*view);
    }
  }
  const splat::SplatView<float>& view() const { return view_; }
  const HostBuffer<float>& image() const { return image_; }
  splat::ViewWorkspace<float>& workspace() { return workspace_; }

 private:
  const splat::Model<float>& model_;
  const JudgingViews& judges_;
  splat::SplatView<float> view_;
  splat::ViewWorkspace<float> workspace_;
  HostBuffer<float> image_;
};

// The loss that trainings lower, 0.8 |e| + 0.2 (1 - SSIM) summed over pixels and channels, for passes that ask what
// changes of it.
class JudgedLoss {
 public:
  // Of that view, until the next call; counted in what follows.
  splat::LinearizedLoss<float> Linearize(HostSpan<const float> rendered, const View& view) {
    const ImageShape shape{view.camera.width, view.camera.height};
    photograph_.reset();  // before the next one takes its room
    photograph_ = view.Photograph();
    const HostSpan<const float> truth = ValuesOf(*photograph_);
    const PhotometricWeights& weights = loss_.weights();
    gradient_.ResizeForOverwrite(shape.NumValues());
    const bool is_masked = !photograph_->mask.empty();
    if (is_masked) rendered = WithPhotograph(rendered, *photograph_);
    cost_ += loss_.Linearize(rendered, truth, shape, gradient_, linearization_).objective;
    values_ += ImageShape::kChannels * static_cast<double>(CountedPixels(*photograph_));
    return {.rendered = rendered.data(),
            .truth = truth.data(),
            .gradient = gradient_.data(),
            .diagonal = linearization_.diagonal.data(),
            .curvature = linearization_.curvature.data(),
            .penalty = PenaltyCoefficientsOf<float>(weights),
            .l1 = static_cast<float>(weights.l1),
            .ssim = static_cast<float>(weights.ssim),
            .window_variance = static_cast<float>(WindowVariance()),
            .counts = is_masked ? counts_.data() : nullptr};
  }
  double cost() const { return cost_; }      // of all views
  double values() const { return values_; }  // their pixels that count, by channel

 private:
  // The image with the photograph where pixels do not count; and counts_.
  HostSpan<const float> WithPhotograph(HostSpan<const float> rendered, const Image& photograph) {
    using Backend = CpuBackend<float>;
    shown_.CopyFrom(rendered);
    ShowLeftOut<Backend>(MaskOf(photograph), ValuesOf(photograph), shown_.view());
    counts_.assign(photograph.mask.begin(), photograph.mask.end());
    for (float& count : counts_) count = count != 0 ? 1.0f : 0.0f;
    return shown_.view();
  }

  std::shared_ptr<const Image> photograph_;
  PhotometricLoss<float> loss_;
  PhotometricLinearization<float> linearization_;
  HostBuffer<float> gradient_, shown_;
  std::vector<float> counts_;
  double cost_ = 0, values_ = 0;
};

}  // namespace vesta::gs
