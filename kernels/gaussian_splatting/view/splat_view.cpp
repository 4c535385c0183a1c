// SPDX-License-Identifier: Apache-2.0
#include "kernels/gaussian_splatting/view/splat_view.h"

#include <algorithm>

#include "kernels/core/check.h"
#include "kernels/core/parallel.h"
#include "kernels/core/profile.h"

namespace vesta::splat {
namespace {

constexpr Index kGaussianGrain = 1024;  // a multiple of every SIMD width
constexpr Index kTileGrain = 4;

template <class T>
void EnsureSize(HostBuffer<T>& buffer, Index size) {
  if (buffer.size() < size) buffer.ResizeForOverwrite(size + size / 8);
}

// splat_sums[k] = the sum of pair_sums over the pairs of splat k, in the order of its tiles. Record: kN scalars.
template <class S, class Record>
void SumPairs(const TileBins& bins, Index num_splats, const Record* pair_sums, Record* splat_sums) {
  constexpr Index kRecordBytes = sizeof(Record), kN = kRecordBytes / static_cast<Index>(sizeof(S));
  ParallelFor(num_splats, kGaussianGrain, [&](Index k) {
    const auto add = [](const Record& from, Record& to) {
      for (Index i = 0; i < kN; ++i) reinterpret_cast<S*>(&to)[i] += reinterpret_cast<const S*>(&from)[i];
    };
    Record sum{};
    const Index end = bins.splat_begin()[k + 1];
    for (Index begin = bins.splat_begin()[k]; begin < end; begin += kTermsPerPartialSum) {
      Record part{};
      const Index part_end = std::min(begin + kTermsPerPartialSum, end);
      for (Index e = begin; e < part_end; ++e) add(pair_sums[bins.pairs_of_splat()[e]], part);
      add(part, sum);
    }
    splat_sums[k] = sum;
  });
}

// Runs pass(tile, pairs) for each tile and sums the records of the pairs per splat.
template <class S, class Record, class Pass>
const Record* SumTiles(const TileBins& bins, Index num_splats, HostBuffer<Record>& pairs, HostBuffer<Record>& splats,
                       const Pass& pass) {
  EnsureSize(pairs, bins.num_pairs());
  EnsureSize(splats, num_splats);
  ParallelFor(bins.num_tiles(), kTileGrain, [&](Index tile) { pass(static_cast<int>(tile), pairs.data()); });
  SumPairs<S>(bins, num_splats, pairs.data(), splats.data());
  return splats.data();
}

// Calls run(kernels, begin, end) for ranges of all Gaussians, with the kernels of their SH degree.
template <class S, class Run>
void ForGaussians(const Model<S>& model, const Run& run) {
  ParallelForChunks(model.count, kGaussianGrain, [&](Index begin, Index end) {
    model.ForEachDegree(begin, end,
                        [&](int degree, Index from, Index to) { run(GetProjectKernels<S>(degree), from, to); });
  });
}

}  // namespace

template <class S>
void SplatView<S>::Build(const Model<S>& model, const PosedCamera& view, const double background[3],
                         ViewWorkspace<S>& workspace) {
  camera_ = view;
  cache_.Clear();
  for (int c = 0; c < 3; ++c) background_[c] = static_cast<S>(background[c]);
  const Index count = model.count;
  EnsureSize(workspace.keys, count);
  EnsureSize(workspace.unsorted, count);
  ScopedPhase phase("projection");
  ForGaussians(model, [&](const ProjectKernels<S>& kernels, Index begin, Index end) {
    kernels.project(model, view, begin, end, workspace.keys.data(), workspace.unsorted.data());
  });
  phase.Next("sort");
  Index seen = 0;
  for (Index i = 0; i < count; ++i) seen += workspace.keys[i] != kInvisible ? 1 : 0;
  workspace.order.ResizeForOverwrite(seen);
  Index at = 0;
  for (Index i = 0; i < count; ++i) {
    if (workspace.keys[i] != kInvisible) workspace.order[at++] = {workspace.keys[i], static_cast<std::uint32_t>(i)};
  }
  RadixSort(workspace.order, workspace.order_scratch);
  splats_.ResizeForOverwrite(seen);
  rank_of_.ResizeForOverwrite(count);
  std::fill_n(rank_of_.data(), count, -1);
  ParallelFor(seen, kGaussianGrain, [&](Index k) {
    const std::uint32_t i = workspace.order[k].value;
    splats_[k] = workspace.unsorted[i];
    rank_of_[i] = static_cast<std::int32_t>(k);
  });
  bins_.Build<S>(splats_.view(), view.width, view.height);
}

template <class S>
TileLists<S> SplatView<S>::Lists() const {
  return {splats_.data(), bins_.tile_begin(), bins_.ranks(),   camera_.width,
          camera_.height, bins_.tiles_x(),    bins_.tiles_y(), {background_[0], background_[1], background_[2]}};
}

template <class S>
VisitCounts SplatView<S>::CountVisits() const {
  const TileLists<S> lists = Lists();
  VisitCounts sum;
  for (int tile = 0; tile < bins_.num_tiles(); ++tile) {
    const VisitCounts counts = GetRasterKernels<S>().count(lists, tile);
    sum.pairs += counts.pairs;
    sum.vectors += counts.vectors;
    sum.useful += counts.useful;
    sum.pixels += counts.pixels;
  }
  return sum;
}

template <class S>
void SplatView<S>::Render(S* image) const {
  const ScopedPhase phase("raster forward");
  const TileLists<S> lists = Lists();
  const auto& kernels = GetRasterKernels<S>();
  ParallelFor(bins_.num_tiles(), kTileGrain,
              [&](Index tile) { kernels.forward(lists, static_cast<int>(tile), image); });
}

template <class S>
SplatTangent<S>* SplatView<S>::ProjectTangents(const Model<S>& model, const S* dx, ViewWorkspace<S>& workspace) const {
  const ScopedPhase phase("projection tangent");
  EnsureSize(workspace.splat_sums, num_splats());
  SplatTangent<S>* tangents = workspace.splat_sums.data();
  ForGaussians(model, [&](const ProjectKernels<S>& project, Index begin, Index end) {
    project.tangent(model, camera_, begin, end, rank_of_.data(), dx, tangents);
  });
  return tangents;
}

template <class S>
void SplatView<S>::RenderAndApplyJ(const Model<S>& model, const S* dx, S* image, S* d_image,
                                   ViewWorkspace<S>& workspace) const {
  VESTA_CHECK(cache_.empty(), "RenderAndApplyJ does not support a cached Jacobian");
  const SplatTangent<S>* tangents = ProjectTangents(model, dx, workspace);
  const ScopedPhase phase("raster tangent");
  const TileLists<S> lists = Lists();
  const auto& raster = GetRasterKernels<S>();
  ParallelFor(bins_.num_tiles(), kTileGrain,
              [&](Index tile) { raster.forward_tangent(lists, static_cast<int>(tile), tangents, image, d_image); });
}

template <class S>
void SplatView<S>::ApplyRasterJ(const SplatTangent<S>* tangents, S* d_image) const {
  const ScopedPhase phase("raster tangent");
  const TileLists<S> lists = Lists();
  if (!cache_.empty()) return cache_.Tangent(lists, bins_, tangents, d_image);
  const auto& raster = GetRasterKernels<S>();
  ParallelFor(bins_.num_tiles(), kTileGrain,
              [&](Index tile) { raster.tangent(lists, static_cast<int>(tile), tangents, d_image); });
}

template <class S>
void SplatView<S>::ApplyJ(const Model<S>& model, const S* dx, S* d_image, ViewWorkspace<S>& workspace) const {
  ApplyRasterJ(ProjectTangents(model, dx, workspace), d_image);
}

template <class S>
const SplatTangent<S>* SplatView<S>::ApplyRasterJT(const S* image, const S* u, ViewWorkspace<S>& workspace) const {
  const ScopedPhase phase("raster backward");
  const TileLists<S> lists = Lists();
  if (!cache_.empty()) {
    EnsureSize(workspace.splat_sums, num_splats());
    cache_.Adjoint(lists, bins_, u, workspace.splat_sums.data(), workspace.u_tiles);
    return workspace.splat_sums.data();
  }
  return SumTiles<S>(
      bins_, num_splats(), workspace.pair_sums, workspace.splat_sums,
      [&, &raster = GetRasterKernels<S>()](int tile, auto* pairs) { raster.adjoint(lists, tile, image, u, pairs); });
}

template <class S>
void SplatView<S>::AddJT(const Model<S>& model, const S* image, const S* u, S* g, ViewWorkspace<S>& workspace) const {
  const SplatTangent<S>* cotangents = ApplyRasterJT(image, u, workspace);
  const ScopedPhase phase("projection backward");
  ForGaussians(model, [&](const ProjectKernels<S>& project, Index begin, Index end) {
    project.adjoint(model, camera_, begin, end, rank_of_.data(), cotangents, g);
  });
}

template <class S>
void SplatView<S>::AddGram(const Model<S>& model, const S* image, const S* omega, S* blocks, S* sh_diagonal,
                           ViewWorkspace<S>& workspace) const {
  const ScopedPhase phase("Gram blocks");
  const TileLists<S> lists = Lists();
  const SplatGram<S>* grams = SumTiles<S>(
      bins_, num_splats(), workspace.pair_grams, workspace.splat_grams,
      [&, &raster = GetRasterKernels<S>()](int tile, auto* pairs) { raster.gram(lists, tile, image, omega, pairs); });
  ForGaussians(model, [&](const ProjectKernels<S>& project, Index begin, Index end) {
    project.gram(model, camera_, begin, end, rank_of_.data(), grams, blocks, sh_diagonal);
  });
}

template <class S>
void SplatView<S>::AddRemovalRises(const LinearizedLoss<S>& loss, double* rises, ViewWorkspace<S>& workspace) const {
  const ScopedPhase phase("removal pass");
  const TileLists<S> lists = Lists();
  const S* of_view = SumTiles<S>(
      bins_, num_splats(), workspace.pair_rises, workspace.splat_rises,
      [&, &raster = GetRasterKernels<S>()](int tile, auto* pairs) { raster.removal(lists, tile, loss, pairs); });
  ParallelFor(rank_of_.size(), kGaussianGrain, [&](Index i) {
    const std::int32_t rank = rank_of_[i];
    if (rank >= 0) rises[i] += of_view[rank];
  });
}

template <class S>
const ColorCurvature<S>* SplatView<S>::ColorCurvatures(const LinearizedLoss<S>& loss,
                                                       ViewWorkspace<S>& workspace) const {
  const ScopedPhase phase("recolour pass");
  const TileLists<S> lists = Lists();
  return SumTiles<S>(bins_, num_splats(), workspace.pair_colors, workspace.splat_colors,
                     [&, &raster = GetRasterKernels<S>()](int tile, auto* pairs) {
                       raster.color_curvature(lists, tile, loss, pairs);
                     });
}

template <class S>
void SplatView<S>::SumRecolorRises(const LinearizedLoss<S>& loss, RecolorRises<double>* rises,
                                   ViewWorkspace<S>& workspace) const {
  const ScopedPhase phase("recolour pass");
  const TileLists<S> lists = Lists();
  const RecolorRises<S>* of_view = SumTiles<S>(bins_, num_splats(), workspace.pair_recolors, workspace.splat_recolors,
                                               [&, &raster = GetRasterKernels<S>()](int tile, auto* pairs) {
                                                 raster.recolor(lists, tile, loss, workspace.recolors.data(), pairs);
                                               });
  ParallelFor(rank_of_.size(), kGaussianGrain, [&](Index i) {
    const std::int32_t rank = rank_of_[i];
    for (int d = 0; rank >= 0 && d < kRecolors; ++d) rises[i].rise[d] += of_view[rank].rise[d];
  });
}

template class SplatView<float>;
template class SplatView<double>;

}  // namespace vesta::splat
