// SPDX-License-Identifier: Apache-2.0
#include "splatting/memory/stage_bytes.h"

#include <algorithm>
#include <cmath>
#include <type_traits>

#include "kernels/core/packed.h"
#include "kernels/gaussian_splatting/formulas/layout.h"
#include "kernels/gaussian_splatting/raster/raster_blocks.h"
#include "kernels/gaussian_splatting/view/splat_view.h"
#include "kernels/math/spherical_harmonics.h"
#include "problems/gaussian_splatting/lm/lm_stage_options.h"
#include "problems/gaussian_splatting/lm/view_batches.h"
#include "problems/gaussian_splatting/model/device_splat_backend.h"
#include "solver/internal/trust_region/step_control.h"
#include "solver/memory.h"
#include "splatting/adam/adam_formula.h"
#include "splatting/adam/adam_steps.h"
#include "splatting/cameras/derivatives/view_columns.h"
#include "splatting/evaluate/evaluation.h"
#include "splatting/pruning/harmonics.h"
#include "splatting/pruning/scoring_views.h"

namespace vesta::gs {
namespace {

using Cpu = CpuBackend<float>;
using Gpu = CudaBackend<float>;

// Sizes of the stages' components in the memory of B, from the classes that allocate them.
template <class B>
class Parts {
 public:
  using Splats = SplatBackend<B>;
  using Workspace = typename Splats::Workspace;
  using Loss = typename Splats::Loss;

  explicit Parts(const MemoryScene& scene)
      : scene_(scene), most_(scene.Largest()), gaussians_(static_cast<double>(scene.layout.count)) {}

  const ViewCounts& most() const { return most_; }
  double Image() const { return kImageBytes * most_.pixels; }
  double View() const { return ViewBytes(most_); }
  // Work memory without Gram matrices.
  double Passes() const { return Workspace::BuildBytes(most_, gaussians_) + Workspace::ProductBytes(most_); }
  // With masks on a device; on the host, masks belong to the views.
  double Truths() const {
    double bytes = kIsDevice ? scene_.mask_bytes : 0;
    for (const ViewCounts& view : scene_.views) bytes += Splats::TruthBytes(view.pixels);
    return bytes;
  }
  // Without the workspace: a view, its image and truth, and the quality meter.
  double Evaluation() const {
    return View() + Image() + Splats::TruthBytes(most_.pixels) + Splats::QualityMeter::Bytes(most_.pixels);
  }
  // Curvature of a view by its camera (cameras/derivatives/view_columns.h): another view with its passes, and its
  // derivative images. The peak is either images and columns, or columns and the product of W with one of them.
  double CameraCurvature(const CameraOptions& cameras) const {
    if (!cameras.refines()) return 0;
    // The largest choice of auto.
    const FreeUnknowns free = FreeBy(cameras.refine == CameraChoice::kAuto ? CameraChoice::kPose : cameras.refine);
    const auto columns = static_cast<double>(ViewColumns<B>::NumImages(free));
    const int weighted = 2 + LinearizationImages(SsimLinearization::kQuadratic);
    return View() + Passes() + (1 + columns + std::max(free.num_moves(), weighted)) * Image() +
           Loss::ProductBytes(SsimLinearization::kQuadratic, most_.pixels);
  }
  // On the host, wherever the stages run. pruning/harmonics.h takes the most memory.
  double Scoring(const PruningOptions& pruning) const {
    if (!pruning.needs_scoring()) return 0;
    return RenderedViewsBytes(most_, gaussians_) +
           (pruning.sh_aic_weight > 0 ? ShRemovalCost::kBytes : kRemovalCostBytes) * gaussians_;
  }
  // The session's renderer.
  double SessionWorkspace() const {
    return std::is_same_v<typename B::Space, Host> ? Workspace::BuildBytes(most_, gaussians_) : 0;
  }
  // A view with its image, the images of its loss, and its cached Jacobian.
  double LinearizedView(const ViewCounts& view, const LmStageOptions& lm) const {
    const double bytes = ViewBytes(view) + (1 + LinearizationImages(lm.ssim)) * kImageBytes * view.pixels;
    if (!IsCached(lm.jacobian)) return bytes;
    const auto format = lm.jacobian == JacobianKind::kCache32 ? splat::CacheFormat::kFull : splat::CacheFormat::kHalf;
    return bytes + static_cast<double>(Splats::SplatView::Cache::NumBytes(static_cast<Index>(view.entries),
                                                                          static_cast<Index>(view.pairs), format));
  }

 private:
  static constexpr bool kIsDevice = !std::is_same_v<typename B::Space, Host>;
  // Per Gaussian: the rise in one view, in all and at most, a score, and a sorted index.
  static constexpr double kRemovalCostBytes = 4 * sizeof(double) + sizeof(Index);

  double ViewBytes(const ViewCounts& view) const { return Splats::SplatView::Bytes(view, gaussians_); }

  const MemoryScene& scene_;
  ViewCounts most_;
  double gaussians_;
};

// Terms of an iteration with several views (distributed/sum_of_views.h): two operands and the result of the last sum,
// and one term for each level below. Each view may see nearly all Gaussians; a term has their gradient and pull.
double TermBytes(const MemoryScene& scene, int views) {
  if (views == 1) return 0;
  const double held = 2 + std::ceil(std::log2(views));
  return held * (VectorBytes(scene) + PerGaussianBytes(scene));
}

template <class B>
double AdamBytesIn(const MemoryScene& scene, const StageOptions& options) {
  const Parts<B> parts(scene);
  const double vector = VectorBytes(scene), bases = BasesBytes(scene, options.adam);
  // The model, two moments and the bases. Per Gaussian: units and pulls.
  const double held = parts.Truths() + 3 * vector + bases + 2 * PerGaussianBytes(scene) + parts.SessionWorkspace();
  // The gradient; the image and its gradient; at the end, the mean of the parameters.
  const double step = vector + TermBytes(scene, options.adam.batch_size) + parts.View() + parts.Passes() +
                      2 * parts.Image() +
                      Parts<B>::Loss::GradientBytes(SsimLinearization::kQuadratic, parts.most().pixels) +
                      std::max(parts.Evaluation(), parts.CameraCurvature(options.cameras));
  const double average = options.adam.averaging_fraction > 0 ? vector : 0;
  // While views are scored, the memory of an iteration is free.
  const bool is_host = std::is_same_v<typename B::Space, Host>;
  const double scoring = is_host ? vector + parts.Scoring(options.pruning) : 0;
  // A second copy of the bases or of a vector; sources and actions.
  const double rearranging = options.density.enabled ? std::max(vector, bases) + 1.25 * PerGaussianBytes(scene) : 0;
  return held + std::max(std::max(step, scoring) + average, rearranging);
}

template <class B>
double LmBytesIn(const MemoryScene& scene, const LmStageOptions& lm, bool hold_batches, bool keeps_gram = false) {
  const Parts<B> parts(scene);
  using Workspace = typename Parts<B>::Workspace;
  double views_bytes = 0, rebuilt = 0;
  if (lm.jacobian == JacobianKind::kOnTheFly) {
    // One view per linearization.
    const Index batches = ViewBatches::CutCount(lm.batches, lm.batch_size, static_cast<Index>(scene.views.size()));
    rebuilt = (hold_batches ? static_cast<double>(batches) : 1) * parts.LinearizedView(parts.most(), lm);
  } else {
    for (const ViewCounts& view : scene.views) views_bytes += parts.LinearizedView(view, lm);
  }
  const PassingBytes passing{.gram = Workspace::GramBytes(parts.most()),
                             .cost = parts.View() + parts.Image(),
                             .evaluation = parts.Evaluation(),
                             .keeps_gram = keeps_gram};
  // One unit of length per Gaussian.
  return parts.Truths() + EngineBytes(scene, lm, hold_batches, views_bytes, passing) + PerGaussianBytes(scene) +
         rebuilt + parts.Passes() + (IsCached(lm.jacobian) ? Workspace::CacheBytes(parts.most()) : 0) +
         Parts<B>::Loss::ProductBytes(lm.ssim, parts.most().pixels) + parts.SessionWorkspace();
}

template <class B>
double JointLmBytesIn(const MemoryScene& scene, const StageOptions& options, bool eliminate_views) {
  LmStageOptions lm = options.lm;
  lm.jacobian = JacobianKind::kCachedViews, lm.batches = 1, lm.batch_size = 0, lm.line_search = false;
  const FreeUnknowns free = FreeBy(options.cameras.refine);
  // Columns of the pose, and of the gains and offsets per channel. Meanwhile, the workspace of Gram matrices is free.
  // The peak is either images and columns, or columns and W J.
  const auto columns = static_cast<double>(ViewColumns<B>::NumImages(free));
  const double beside_columns = std::max<double>(free.num_moves(), eliminate_views ? columns : 1);
  const ViewCounts most = scene.Largest();
  const double making = (columns + beside_columns - (eliminate_views ? columns : 0)) * kImageBytes * most.pixels;
  double beside = std::max(0.0, making - SplatBackend<B>::Workspace::GramBytes(most));
  // On the host, photographs with the optimised exposures applied.
  const double developed = std::is_same_v<typename B::Space, Host> && free.color ? 1 : 0;
  for (const ViewCounts& view : scene.views) {
    beside += (developed + (eliminate_views ? columns : 0)) * kImageBytes * view.pixels;
  }
  // The gradient, the right-hand side, and the right-hand side without the views.
  constexpr double kVectors = 3;
  return LmBytesIn<B>(scene, lm, true, eliminate_views) + beside + kVectors * VectorBytes(scene);
}

}  // namespace

MemoryScene CountMemory(const splat::Model<float>& model, const std::vector<const View*>& views, double near, int most,
                        bool with_entries) {
  const double background[3] = {0, 0, 0};
  splat::SplatView<float> view;
  splat::ViewWorkspace<float> workspace;
  std::vector<ViewCounts> counts(views.size());
  ViewCounts sum;
  const double share = std::min(1.0, static_cast<double>(most) / static_cast<double>(views.size()));
  const std::vector<Index> counted = SpreadUnits(static_cast<Index>(views.size()), share, 0);
  for (const Index v : counted) {
    view.Build(model, ToPosedCamera(*views[static_cast<std::size_t>(v)], near), background, workspace);
    sum.splats += static_cast<double>(view.num_splats());
    sum.pairs += static_cast<double>(view.num_pairs());
    const double entries = with_entries ? static_cast<double>(view.CountVisits().pixels) : 0;
    sum.entries += entries;
    counts[static_cast<std::size_t>(v)] = {.splats = static_cast<double>(view.num_splats()),
                                           .pairs = static_cast<double>(view.num_pairs()),
                                           .entries = entries};
  }
  const auto number = static_cast<double>(counted.size());
  for (std::size_t v = 0, next = 0; v < views.size(); ++v) {
    if (next < counted.size() && counted[next] == static_cast<Index>(v)) {
      ++next;
    } else {
      counts[v] = {.splats = sum.splats / number, .pairs = sum.pairs / number, .entries = sum.entries / number};
    }
    const Camera& camera = views[v]->camera;
    const auto tiles = [](int size) { return (size + splat::kTileSize - 1) / splat::kTileSize; };
    counts[v].pixels = camera.pixels();
    counts[v].tiles = static_cast<double>(tiles(camera.width)) * tiles(camera.height);
  }
  double mask_bytes = 0;
  for (const View* v : views) mask_bytes += static_cast<double>(v->image.mask.size());
  return {.layout = model, .views = std::move(counts), .mask_bytes = mask_bytes};
}

MemoryScene MemoryScene::Scaled(Index new_gaussians) const {
  const double factor = static_cast<double>(new_gaussians) / static_cast<double>(std::max<Index>(layout.count, 1));
  MemoryScene scene = *this;
  scene.layout.count = new_gaussians;
  for (std::int64_t& number : scene.layout.without_band)
    number = static_cast<Index>(factor * static_cast<double>(number));
  for (ViewCounts& view : scene.views) view.splats *= factor, view.pairs *= factor, view.entries *= factor;
  return scene;
}

MemoryScene MemoryScene::Of(const splat::ModelLayout& other) const {
  MemoryScene scene = Scaled(other.count);
  scene.layout = other;
  return scene;
}

ViewCounts MemoryScene::Largest() const {
  ViewCounts most;
  for (const ViewCounts& view : views) {
    most.pixels = std::max(most.pixels, view.pixels), most.tiles = std::max(most.tiles, view.tiles);
    most.splats = std::max(most.splats, view.splats), most.pairs = std::max(most.pairs, view.pairs);
  }
  return most;
}

const schema::Table<MemoryOptions>& MemoryFields() {
  using O = MemoryOptions;
  static const schema::Table<O> fields = {
      {"budget_gib",
       &O::budget_gib,
       {0, 1e6},
       "use at most X GiB of memory (GPU memory if the GPU trains): with fewer Gaussians and a slower LM if needed, or "
       "end with an error; 0: no limit",
       "memory_budget"},
  };
  return fields;
}

double VectorBytes(const MemoryScene& scene) { return sizeof(float) * static_cast<double>(scene.layout.Size()); }

double PerGaussianBytes(const MemoryScene& scene) { return sizeof(float) * static_cast<double>(scene.layout.count); }

double BasesBytes(const MemoryScene& scene, const AdamOptions& options) {
  return options.second_moment == SecondMoment::kBlock
             ? sizeof(float) * static_cast<double>(BlockArraySize(scene.layout.count))
             : 0;
}

// Packed blocks of the geometry, and the diagonal of the harmonics.
double GramBytes(const MemoryScene& scene) {
  return (PackedSize(splat::kGeometry) - splat::kSh) * PerGaussianBytes(scene) + VectorBytes(scene);
}

double EngineBytes(const MemoryScene& scene, const LmStageOptions& lm, bool hold_batches, double views_bytes,
                   const PassingBytes& passing) {
  vesta::LmOptions engine = LmEngineOptions(lm);
  engine.hold_batches = hold_batches;
  const auto views = static_cast<double>(scene.views.size());
  const Index batches = ViewBatches::CutCount(lm.batches, lm.batch_size, static_cast<Index>(scene.views.size()));
  const int linearizations = HeldLinearizations(engine, static_cast<int>(batches));
  // Batches differ by at most one view.
  const double size =
      std::ceil(lm.batch_size > 0 ? std::min<double>(lm.batch_size, views) : views / static_cast<double>(batches));
  const double held = std::min(linearizations * size, views);
  // Gram matrices, which become the blocks of a preconditioner.
  const double blocks = GramBytes(scene);
  const double vector = VectorBytes(scene);
  return LmPeakBytes(engine, {.batches = static_cast<int>(batches),
                              .vector = vector,
                              .linearization = views_bytes * (views > 0 ? held / views : 0) / linearizations +
                                               2 * kImageBytes * scene.Largest().pixels,
                              .gram = blocks,
                              .gram_work = passing.gram,
                              .keeps_gram = passing.keeps_gram,
                              .blocks = blocks,
                              .cost_work = passing.cost,
                              .between = passing.evaluation,
                              .has_own_right_hand_side = lm.gradient_shrinkage > 0,
                              .has_own_metric = lm.damping == LmDamping::kLearningRates});
}

double AdamBytes(const MemoryScene& scene, const StageOptions& options) { return AdamBytesIn<Cpu>(scene, options); }
double DeviceAdamBytes(const MemoryScene& scene, const StageOptions& options) {
  return AdamBytesIn<Gpu>(scene, options);
}

double LmBytes(const MemoryScene& scene, const LmStageOptions& lm, bool hold_batches) {
  return LmBytesIn<Cpu>(scene, lm, hold_batches);
}
double DeviceLmBytes(const MemoryScene& scene, const LmStageOptions& lm, bool hold_batches) {
  return LmBytesIn<Gpu>(scene, lm, hold_batches);
}

double JointLmBytes(const MemoryScene& scene, const StageOptions& options, bool eliminate_views) {
  return JointLmBytesIn<Cpu>(scene, options, eliminate_views);
}
double DeviceJointLmBytes(const MemoryScene& scene, const StageOptions& options, bool eliminate_views) {
  return JointLmBytesIn<Gpu>(scene, options, eliminate_views);
}

double ScoringBytes(const MemoryScene& scene, const PruningOptions& pruning) {
  return Parts<Cpu>(scene).Scoring(pruning);
}

double ModelBytes(const MemoryScene& scene) {
  const Parts<Cpu> parts(scene);
  return VectorBytes(scene) + parts.SessionWorkspace() + parts.Evaluation() +
         Parts<Cpu>::Loss::GradientBytes(SsimLinearization::kQuadratic, parts.most().pixels);
}

}  // namespace vesta::gs
