#include "problems/gaussian_splatting/train/memory_plan.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "kernels/core/check.h"
#include "kernels/core/parallel.h"
#include "kernels/gaussian_splatting/jacobian_cache.h"
#include "kernels/gaussian_splatting/layout.h"
#include "kernels/gaussian_splatting/view.h"
#include "kernels/image/image_kernels.h"
#include "kernels/math/spherical_harmonics.h"
#include "problems/gaussian_splatting/lm/view_batches.h"
#include "problems/gaussian_splatting/train/adam.h"
#include "problems/gaussian_splatting/train/block_adam_formula.h"
#include "problems/gaussian_splatting/train/metrics.h"
#include "solver/line_search.h"

namespace vesta::gs {
namespace {

constexpr double kFloat = sizeof(float), kImage = 3 * kFloat;  // of a pixel
constexpr double kMib = 1 << 20, kGib = 1 << 30;

constexpr int Packed(int size) { return size * (size + 1) / 2; }

// The largest of each count over the views.
ViewCounts Largest(const std::vector<ViewCounts>& views) {
  ViewCounts most;
  for (const ViewCounts& view : views) {
    most.pixels = std::max(most.pixels, view.pixels), most.tiles = std::max(most.tiles, view.tiles);
    most.splats = std::max(most.splats, view.splats), most.pairs = std::max(most.pairs, view.pairs);
  }
  return most;
}

// One vector of parameters.
double VectorBytes(const MemoryScene& scene) {
  return kFloat * splat::NumAttributes(scene.sh_degree) * static_cast<double>(scene.gaussians);
}

// Units of length.
double UnitBytes(Index gaussians) { return kFloat * static_cast<double>(gaussians); }

// A splat::View<float>.
double ViewBytes(const ViewCounts& view, Index gaussians) {
  const double offsets = sizeof(std::int64_t), index = sizeof(std::uint32_t);
  return view.splats * (sizeof(splat::Splat<float>) + offsets) + index * static_cast<double>(gaussians) +
         view.tiles * offsets + 3 * index * view.pairs;
}

// The parts of a splat::ViewWorkspace<float> that projecting, J^T, and Gram matrices need.
double ProjectBytes(const ViewCounts& view, Index gaussians) {
  return static_cast<double>(gaussians) * (sizeof(std::uint32_t) + sizeof(splat::Splat<float>)) +
         2 * sizeof(KeyValue) * view.splats;
}
double SumBytes(const ViewCounts& view, std::size_t record) {
  return (view.splats + view.pairs) * static_cast<double>(record);
}

// What PhotometricLoss<float> works in, all its objects together: scratch rows for each thread (an image is taken to be
// up to twice as wide as high).
double LossBytes(const ViewCounts& view) {
  const auto width = static_cast<int>(std::sqrt(2 * view.pixels));
  return kFloat * NumThreads() * static_cast<double>(RowRange<float>::kScratchRows * ScratchStride(width));
}

// Images that a PhotometricLinearization<float> holds.
int LossImages(const LmOptions& lm) {
  if (lm.ssim_linearization != "root") return 2;
  return lm.ssim_jacobian == "center" ? 1 : 5;
}

// What an evaluation needs while a stage is under way: a renderer, its image, and the meters.
double EvaluationBytes(const ViewCounts& view, Index gaussians) {
  return ViewBytes(view, gaussians) + ProjectBytes(view, gaussians) + 3 * kImage * view.pixels + LossBytes(view);
}

double CacheBytes(const ViewCounts& view, const std::string& jacobian) {
  if (jacobian == "recompute") return 0;
  const auto format = jacobian == "cache32" ? splat::CacheFormat::kFull : splat::CacheFormat::kHalf;
  return static_cast<double>(
      splat::JacobianCache<float>::NumBytes(static_cast<Index>(view.entries), static_cast<Index>(view.pairs), format));
}

// Values of the preconditioner's blocks (BlockDiagonal), 0 for Jacobi.
double BlockValues(const MemoryScene& scene, const std::string& preconditioner) {
  const int coefficients = ShCoefficients(scene.sh_degree);
  if (preconditioner == "jacobi") return 0;
  const int colors = preconditioner == "block_sh" ? Packed(coefficients) : 3 * coefficients;
  return static_cast<double>(scene.gaussians) * (Packed(splat::kGeometry) + colors);
}

// A SplatLinearization, without its views.
double LinearizationBytes(const MemoryScene& scene, const LmOptions& lm, const ViewCounts& most) {
  const int coefficients = ShCoefficients(scene.sh_degree);
  const int gram =
      Packed(splat::kGeometry) + 3 * coefficients + (lm.preconditioner == "block_sh" ? Packed(coefficients) : 0);
  return 2 * VectorBytes(scene) + kFloat * gram * static_cast<double>(scene.gaussians) + 2 * kImage * most.pixels;
}

// A NormalSystem: gradient, diagonal, metric, right-hand side and mask; of Jacobi the diagonal and its inverse, else
// the blocks and their factors.
double SystemBytes(const MemoryScene& scene, const LmOptions& lm) {
  const double blocks = BlockValues(scene, lm.preconditioner);
  return (blocks == 0 ? 7 : 5) * VectorBytes(scene) + 2 * kFloat * blocks;
}

double LinearizedViewBytes(const ViewCounts& view, Index gaussians, const LmOptions& lm) {
  // The image, and those of its loss.
  return ViewBytes(view, gaussians) + (1 + LossImages(lm)) * kImage * view.pixels + CacheBytes(view, lm.jacobian);
}

// What is left of the budget for the model and the stages.
double BudgetBytes(const MemoryOptions& memory) {
  if (memory.budget_gib <= 0) return std::numeric_limits<double>::infinity();
  return memory.budget_gib * kGib - memory.before_mib * kMib;
}

[[noreturn]] void FailForBudget(const MemoryOptions& memory, double needed, const char* what) {
  Fail(
      "--memory_budget={}: {} needs {:.2f} GiB, {:.2f} of them for program and images; allow so much, or use "
      "--downscale or fewer Gaussians",
      memory.budget_gib, what, needed / kGib + memory.before_mib / 1024 + 0.005, memory.before_mib / 1024);
}

}  // namespace

MemoryScene CountMemory(const SplatModel& model, const std::vector<const View*>& views, double near, int most,
                        bool with_entries) {
  const double background[3] = {0, 0, 0};
  splat::View<float> view;
  splat::ViewWorkspace<float> workspace;
  std::vector<ViewCounts> counts(views.size());
  ViewCounts sum;
  const double share = std::min(1.0, static_cast<double>(most) / static_cast<double>(views.size()));
  const std::vector<Index> counted = SpreadUnits(static_cast<Index>(views.size()), share, 0);
  for (const Index v : counted) {
    view.Build(ToKernelModel(model), ToPinhole(*views[static_cast<std::size_t>(v)], near), background, workspace);
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
    counts[v].pixels = static_cast<double>(camera.width) * camera.height;
    counts[v].tiles = static_cast<double>(tiles(camera.width)) * tiles(camera.height);
  }
  return {model.count, model.sh_degree, std::move(counts)};
}

MemoryScene MemoryScene::Scaled(Index new_gaussians) const {
  const double factor = static_cast<double>(new_gaussians) / static_cast<double>(std::max<Index>(gaussians, 1));
  MemoryScene scene = *this;
  scene.gaussians = new_gaussians;
  for (ViewCounts& view : scene.views) view.splats *= factor, view.pairs *= factor, view.entries *= factor;
  return scene;
}

double AdamBytes(const MemoryScene& scene, const TrainOptions& options) {
  const bool density = options.density.enabled, blocks = MetricOf(options.adam) == AdamMetric::kBlock;
  const ViewCounts most = Largest(scene.views);
  const Index n = scene.gaussians;
  const double of_blocks = kFloat * static_cast<double>(n);
  // The model, its gradient and two moments; while Gaussians are rearranged one vector is there twice, or the bases of
  // blocks.
  const double rearranged = density ? std::max(VectorBytes(scene), blocks ? kBlockNumbers * of_blocks : 0.0) : 0.0;
  return 4 * VectorBytes(scene) + rearranged + (blocks ? kBlockNumbers * of_blocks : 0.0) + UnitBytes(n) +
         (density ? 2 * kFloat * static_cast<double>(n) : 0) + ViewBytes(most, n) + ProjectBytes(most, n) +
         SumBytes(most, sizeof(splat::SplatTangent<float>)) + 2 * kImage * most.pixels + EvaluationBytes(most, n);
}

double LmBytes(const MemoryScene& scene, const LmOptions& lm, bool hold_batches) {
  const ViewCounts most = Largest(scene.views);
  const Index n = scene.gaussians;
  double views_bytes = 0;
  for (const ViewCounts& view : scene.views) views_bytes += LinearizedViewBytes(view, n, lm);
  const auto views = static_cast<double>(scene.views.size());
  const auto batches =
      static_cast<double>(ViewBatches::CutCount(lm.batches, lm.batch_size, static_cast<Index>(scene.views.size())));
  // Views in each batch, up to one more in some than in others.
  const double size = std::ceil(lm.batch_size > 0 ? std::min<double>(lm.batch_size, views) : views / batches);
  const double held = hold_batches ? std::min(batches * size, views) : std::min(size, views);
  const double linearizations = hold_batches ? batches : 1, systems = hold_batches && lm.merge_batches ? batches : 1;
  const double batch_bytes = views_bytes * (views > 0 ? held / views : 0) +
                             linearizations * LinearizationBytes(scene, lm, most) + systems * SystemBytes(scene, lm);
  // The model; x, the trial, two steps; two scales; gradient and diagonal; four of PCG; of several batches one more.
  // Where the model is measured along a step, one to hold H's product with it.
  const bool measured = (batches > 1 && lm.merge_batches) || lm.step_limit != "none";
  const double vectors = 1 + 4 + 2 + 2 + 4 + (batches > 1 ? 1 : 0) + (measured ? linearizations : 0);
  double workspace = ProjectBytes(most, n) + SumBytes(most, sizeof(splat::SplatTangent<float>)) +
                     SumBytes(most, sizeof(splat::SplatGram<float>));
  if (lm.jacobian != "recompute") workspace += kImage * splat::kTileSize * splat::kTileSize * most.tiles;
  // The view and image of the cost.
  const double cost = ViewBytes(most, n) + kImage * most.pixels;
  return batch_bytes + vectors * VectorBytes(scene) + UnitBytes(n) + workspace + cost + EvaluationBytes(most, n);
}

LmPlan PlanLm(const MemoryScene& scene, const TrainOptions& options) {
  const LmOptions& lm = options.lm;
  LmPlan plan{lm, true, LmBytes(scene, lm, true)};
  const double budget_bytes = BudgetBytes(options.memory);
  if (lm.iterations == 0 || plan.bytes <= budget_bytes) return plan;
  plan.lm.jacobian = "recompute";
  plan.bytes = LmBytes(scene, plan.lm, true);
  if (plan.bytes <= budget_bytes) return plan;
  plan.lm.merge_batches = true;
  plan.hold_batches = false;
  for (plan.lm.batches = std::max(2, lm.batches); plan.lm.batches <= static_cast<int>(scene.views.size());
       ++plan.lm.batches) {
    plan.lm.batch_size = 0;
    plan.bytes = LmBytes(scene, plan.lm, false);
    if (plan.bytes <= budget_bytes) return plan;
  }
  FailForBudget(options.memory, plan.bytes, "LM with one view a batch");
}

Index PlanGaussians(const MemoryScene& scene, const TrainOptions& options) {
  const bool density = options.density.enabled && options.adam.iterations > 0;
  const Index most = density ? std::max(options.density.max_gaussians, scene.gaussians) : scene.gaussians;
  const double budget_bytes = BudgetBytes(options.memory);
  const auto bytes_of = [&](Index gaussians) {
    const MemoryScene scaled = scene.Scaled(gaussians);
    LmOptions lm = options.lm;
    lm.jacobian = "recompute";
    lm.batches = static_cast<int>(scene.views.size());
    const double adam = options.adam.iterations > 0 ? AdamBytes(scaled, options) : 0;
    return std::max(adam, lm.iterations > 0 ? LmBytes(scaled, lm, false) : 0.0);
  };
  if (bytes_of(scene.gaussians) > budget_bytes) {
    FailForBudget(options.memory, bytes_of(scene.gaussians), "this scene");
  }
  Index fits = scene.gaussians, too_many = most + 1;
  while (too_many - fits > 1) {
    const Index middle = fits + (too_many - fits) / 2;
    (bytes_of(middle) <= budget_bytes ? fits : too_many) = middle;
  }
  return fits;
}

double PredictedMib(const MemoryScene& scene, const TrainOptions& options, double lm_bytes) {
  const double evaluation = VectorBytes(scene) + EvaluationBytes(Largest(scene.views), scene.gaussians);
  const double adam = options.adam.iterations > 0 ? AdamBytes(scene, options) : 0;
  return options.memory.before_mib + std::max({adam, lm_bytes, evaluation}) / kMib;
}

}  // namespace vesta::gs
