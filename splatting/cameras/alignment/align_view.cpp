// SPDX-License-Identifier: Apache-2.0
#include "splatting/cameras/alignment/align_view.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "kernels/core/check.h"
#include "problems/gaussian_splatting/model/masked_loss.h"
#include "problems/gaussian_splatting/model/targets.h"
#include "problems/gaussian_splatting/scene/scene.h"
#include "solver/levenberg_marquardt.h"
#include "splatting/cameras/derivatives/view_problem.h"
#include "splatting/cameras/unknowns/moved_view.h"
#include "splatting/evaluate/evaluation.h"

namespace vesta::gs {
namespace {

using DoubleBackend = CpuBackend<double>;

// ViewProblem with a fixed camera, so the image is rendered only once.
class ExposureProblem final : public Problem<DoubleBackend>, public OnManifold<DoubleBackend> {
 public:
  ExposureProblem(HostSpan<const float> rendered, HostSpan<const float> truth, const ImageShape& shape,
                  const PhotometricWeights& weights, HostSpan<const std::uint8_t> mask)
      : rendered_(rendered), loss_(std::make_shared<PhotometricLoss<float>>(weights)) {
    target_.camera.width = shape.width, target_.camera.height = shape.height;
    target_.truth = truth, target_.mask = mask;
  }

  Index num_parameters() const override { return kViewParameters; }
  Index num_tangent() const override { return kFree.num_tangent(); }
  double Cost(ConstVectorView x) override {
    image_.CopyFrom(rendered_);
    Unpack(x).color.Apply(image_.view());
    return EvaluateLoss(*loss_, target_, image_.view()).cost;
  }
  std::unique_ptr<Linearization<DoubleBackend>> Linearize(ConstVectorView x) override {
    HostBuffer<float> rendered;
    rendered.CopyFrom(rendered_);
    return std::make_unique<ViewLinearization<float>>(kFree, Unpack(x).color, target_, std::move(rendered),
                                                      HostBuffer<float>(), loss_);
  }
  void Plus(DoubleBackend& /*backend*/, ConstVectorView x, ConstVectorView delta, VectorView out) override {
    Pack(gs::Plus(Unpack(x), kFree, delta), out);
  }

 private:
  static constexpr FreeUnknowns kFree{.pose = false, .color = true};

  HostSpan<const float> rendered_;
  TargetView<CpuBackend<float>> target_{};
  std::shared_ptr<PhotometricLoss<float>> loss_;
  HostBuffer<float> image_;
};

constexpr int kLeastSide = 32;  // pixels: three SSIM windows

bool AllFinite(const View& view) {
  const auto finite = [](const auto& values) {
    return std::all_of(values.begin(), values.end(), [](auto value) { return std::isfinite(value); });
  };
  return finite(view.image.rgb) && finite(view.rotation) && finite(view.translation);
}

// True if no channel varies by more than the rounding of 8 bits.
bool IsFlat(const Image& image) {
  for (int c = 0; c < ImageShape::kChannels; ++c) {
    const float* plane = image.plane(c);
    const auto [low, high] = std::minmax_element(plane, plane + image.num_pixels());
    if (*high - *low > 1.5f / 255) return false;
  }
  return true;
}

// Level 0 is full size. The image is `view.image` at level 0, else `shrunk`.
TargetView<CpuBackend<float>> TargetAt(const View& view, int level, double near, Image& shrunk) {
  const ImageSize size = DownscaledSize({view.camera.width, view.camera.height}, 1 << level);
  View small = MovedView(view, {});
  small.camera = ResizeCamera(view.camera, size.width, size.height);
  if (level > 0) shrunk = ResizeArea(view.image, size.width, size.height);
  const std::vector<float>& rgb = level > 0 ? shrunk.rgb : view.image.rgb;
  const std::vector<std::uint8_t>& mask = level > 0 ? shrunk.mask : view.image.mask;
  return {ToPosedCamera(small, near),
          {rgb.data(), static_cast<Index>(rgb.size())},
          {mask.data(), static_cast<Index>(mask.size())}};
}

LmOptions EngineOptions(const AlignOptions& options, int level) {
  LmOptions engine;
  engine.max_iterations = options.max_iterations;
  // Changes below 1e-7 of the cost are noise: some alphas cross their cutoff and the depth order changes when the
  // camera moves. Smaller images only provide a start.
  engine.function_tolerance = level == 0 ? 1e-7 : 1e-5;
  return engine;
}

// Marks a value that was not measured; 0 dB would be a result.
constexpr double kNothing = std::numeric_limits<double>::quiet_NaN();

// Columns [begin, end).
Image Columns(const Image& image, int begin, int end) {
  Image part(end - begin, image.height);
  for (int row = 0; row < 3 * image.height; ++row) {
    const float* from = image.rgb.data() + static_cast<std::ptrdiff_t>(row) * image.width;
    std::copy(from + begin, from + end, part.rgb.data() + static_cast<std::ptrdiff_t>(row) * part.width);
  }
  for (int row = 0; row < part.height && !image.mask.empty(); ++row) {
    const auto from = image.mask.begin() + static_cast<std::ptrdiff_t>(row) * image.width;
    part.mask.insert(part.mask.end(), from + begin, from + end);
  }
  return part;
}

// Measures the unmasked pixels.
ImageQuality Measure(ImageQualityMeter& meter, Image rendered, const Image& truth) {
  FillMasked<CpuBackend<float>>(MaskOf(truth), ValuesOf(truth),
                                {rendered.rgb.data(), static_cast<Index>(rendered.rgb.size())});
  const ImageQuality whole = meter.Measure(ValuesOf(rendered), ValuesOf(truth), {truth.width, truth.height});
  return truth.mask.empty() ? whole : QualityOfMaskedImage(whole, UnmaskedFraction(truth));
}

bool HasCountedHalves(const Image& image) {
  const int middle = image.width / 2;
  return middle > 0 && UnmaskedPixels(Columns(image, 0, middle)) > 0 &&
         UnmaskedPixels(Columns(image, middle, image.width)) > 0;
}

void MeasureHalves(ImageQualityMeter& meter, const PhotometricWeights& weights, const Image& rendered,
                   const Image& truth, AlignedView& view) {
  const int middle = truth.width / 2;
  view.has_halves = true;
  const Image left = Columns(rendered, 0, middle), left_truth = Columns(truth, 0, middle);
  view.exposure =
      FitExposure(ValuesOf(left), ValuesOf(left_truth), {middle, truth.height}, weights, MaskOf(left_truth));
  Image right = Columns(rendered, middle, truth.width);
  const Image right_truth = Columns(truth, middle, truth.width);
  view.right = Measure(meter, right, right_truth);
  view.exposure.Apply(HostSpan<float>{right.rgb.data(), static_cast<Index>(right.rgb.size())});
  view.right_exposed = Measure(meter, right, right_truth);
}

Quality Mean(const std::vector<AlignedView>& views, ImageQuality AlignedView::*of) {
  Quality mean;
  const bool is_of_halves = of != &AlignedView::whole;
  for (const AlignedView& view : views) {
    if (is_of_halves && !view.has_halves) continue;
    mean.psnr += (view.*of).psnr, mean.ssim += (view.*of).ssim;
    ++mean.views;
  }
  mean.psnr = mean.views > 0 ? mean.psnr / mean.views : kNothing;
  mean.ssim = mean.views > 0 ? mean.ssim / mean.views : kNothing;
  return mean;
}

}  // namespace

AffineColor FitExposure(HostSpan<const float> rendered, HostSpan<const float> truth, const ImageShape& shape,
                        const PhotometricWeights& weights, HostSpan<const std::uint8_t> mask) {
  VESTA_CHECK(rendered.size() == shape.NumValues() && truth.size() == shape.NumValues(),
              "rendered {}, truth {} values, want {}", rendered.size(), truth.size(), shape.NumValues());
  ExposureProblem problem(rendered, truth, shape, weights, mask);
  HostBuffer<double> x(kViewParameters);
  Pack({}, x);
  SolveLm(problem, x);
  return Unpack(x).color;
}

const char* ToString(AlignStatus status) {
  switch (status) {
    case AlignStatus::kConverged:
      return "converged";
    case AlignStatus::kStopped:
      return "stopped";
    case AlignStatus::kSeesNothing:
      return "sees nothing";
    case AlignStatus::kFlatImage:
      return "flat image";
    case AlignStatus::kNotFinite:
      return "not finite";
    case AlignStatus::kNoGain:
      return "no gain";
  }
  return "?";
}

Alignment AlignView(const SplatModel& model, const View& view, const AlignOptions& options) {
  VESTA_CHECK(options.levels >= 1 && options.levels <= 16, "{} sizes to align at; choose 1 to 16", options.levels);
  VESTA_CHECK(view.image.width == view.camera.width && view.image.height == view.camera.height,
              "a view of {} x {} with an image of {} x {}", view.camera.width, view.camera.height, view.image.width,
              view.image.height);
  Alignment alignment;
  const auto end_with = [&](AlignStatus status) {
    alignment.status = status;
    return alignment;
  };
  if (!AllFinite(view)) return end_with(AlignStatus::kNotFinite);
  if (IsFlat(view.image)) return end_with(AlignStatus::kFlatImage);
  const ViewProblemOptions problem_options{options.free, options.background, options.weights};
  const splat::Model<float> kernel_model = ToKernelModel(model);
  DoubleBackend backend;
  HostBuffer<double> start(kViewParameters), x(kViewParameters);
  Pack({}, start);
  x.CopyFrom(start);
  for (int level = options.levels - 1; level >= 0; --level) {
    if (level > 0 && std::min(view.camera.width, view.camera.height) >> level < kLeastSide) continue;
    Image shrunk;
    ViewProblem<float> problem(problem_options, kernel_model, TargetAt(view, level, options.near, shrunk));
    const double values = static_cast<double>(view.image.rgb.size());
    if (level == 0) {
      if (problem.CountVisible(start) == 0) return end_with(AlignStatus::kSeesNothing);
      const double before = problem.Cost(start);
      alignment.cost_before = before / values;
      // The smaller images may lead to a wrong local minimum.
      if (!(problem.Cost(x) < before)) x.CopyFrom(start);
    }
    const LmSummary summary = SolveLm<DoubleBackend>(EngineOptions(options, level), backend, problem, x);
    alignment.iterations += static_cast<int>(summary.iterations.size()) - 1;
    if (level > 0) continue;
    alignment.cost_after = summary.final_cost / values;
    if (IsFailure(summary.status)) return end_with(AlignStatus::kNotFinite);
    if (!(alignment.cost_after < alignment.cost_before)) return end_with(AlignStatus::kNoGain);
    alignment.found = Unpack(x);
    alignment.status = IsConverged(summary.status) ? AlignStatus::kConverged : AlignStatus::kStopped;
  }
  return alignment;
}

AlignedEvaluation EvaluateAligned(const SplatModel& model, const Scene& scene, const AlignOptions& options) {
  AlignedEvaluation evaluation;
  Renderer renderer(options.background, options.near);
  ImageQualityMeter meter;
  std::vector<double> degrees, pixels;
  for (const View& each : scene.views) {
    if (!each.is_test()) continue;
    const View view = HoldingPhotograph(each);
    AlignedView aligned;
    aligned.name = view.name;
    aligned.alignment = AlignView(model, view, options);
    const View moved = AsFound(view, aligned.alignment.found);
    aligned.degrees = aligned.alignment.found.motion.Angle() * 180 / std::numbers::pi;
    aligned.pixels = MedianShift(model, view, moved, options.near);
    const Image rendered = renderer.Render(model, moved);
    aligned.whole = Measure(meter, rendered, view.image);
    if (options.free.color && HasCountedHalves(view.image)) {
      MeasureHalves(meter, options.weights, rendered, view.image, aligned);
    }
    degrees.push_back(aligned.degrees);
    pixels.push_back(aligned.pixels);
    evaluation.not_found += aligned.alignment.is_found() ? 0 : 1;
    evaluation.views.push_back(std::move(aligned));
  }
  evaluation.whole = Mean(evaluation.views, &AlignedView::whole);
  if (options.free.color) {
    evaluation.right = Mean(evaluation.views, &AlignedView::right);
    evaluation.right_exposed = Mean(evaluation.views, &AlignedView::right_exposed);
  }
  const bool has_views = !evaluation.views.empty();
  evaluation.degrees = has_views ? Median(std::move(degrees)) : kNothing;
  evaluation.pixels = has_views ? Median(std::move(pixels)) : kNothing;
  return evaluation;
}

}  // namespace vesta::gs
