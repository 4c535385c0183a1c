// SPDX-License-Identifier: Apache-2.0
// One view of a model: the splats it sees, in order, and the operators between parameters and image.
#pragma once

#include <vector>

#include "kernels/core/buffer.h"
#include "kernels/core/parallel.h"
#include "kernels/core/sort.h"
#include "kernels/gaussian_splatting/cache/jacobian_cache.h"
#include "kernels/gaussian_splatting/formulas/types.h"
#include "kernels/gaussian_splatting/projection/project_kernels.h"
#include "kernels/gaussian_splatting/raster/raster_kernels.h"
#include "kernels/gaussian_splatting/tiles/tiles.h"

namespace vesta::splat {

// Memory that views share while they work one after the other. Contents mean nothing between calls.
template <class S>
struct ViewWorkspace {
  HostBuffer<std::uint32_t> keys;
  HostBuffer<Splat<S>> unsorted;
  HostBuffer<KeyValue> order, order_scratch;
  HostBuffer<SplatTangent<S>> pair_sums, splat_sums;
  HostBuffer<SplatGram<S>> pair_grams, splat_grams;
  HostBuffer<S> pair_rises, splat_rises;
  HostBuffer<ColorCurvature<S>> pair_colors, splat_colors;
  HostBuffer<Recolors<S>> recolors;
  HostBuffer<RecolorRises<S>> pair_recolors, splat_recolors;
  HostBuffer<S> u_tiles;

  // Bytes of what Build takes of it for such a view of so many Gaussians, of what J and J^T take, a cached Jacobian
  // besides, and Gram matrices.
  static double BuildBytes(const ViewCounts& view, double gaussians) {
    return kSpareRoom * gaussians * (sizeof(std::uint32_t) + sizeof(Splat<S>)) + 2 * sizeof(KeyValue) * view.splats;
  }
  static double ProductBytes(const ViewCounts& view) {
    return kSpareRoom * (view.splats + view.pairs) * sizeof(SplatTangent<S>);
  }
  static double CacheBytes(const ViewCounts& view) { return 3 * sizeof(S) * kTileSize * kTileSize * view.tiles; }
  static double GramBytes(const ViewCounts& view) {
    return kSpareRoom * (view.splats + view.pairs) * sizeof(SplatGram<S>);
  }
};

// The image of a model in a view is y -> image after x -> y: J = J_raster J_project, both linear maps below at the x
// given to Build. All parallel; every result is bit-identical for any number of threads.
template <class S>
class SplatView {
 public:
  using Cache = JacobianCache<S>;

  // Of such a view of so many Gaussians, without a cache.
  static double Bytes(const ViewCounts& view, double gaussians) {
    return sizeof(Splat<S>) * view.splats + sizeof(std::int32_t) * gaussians + TileBins::Bytes(view);
  }

  // Projects, sorts by (depth, index) and bins. x is read here and again by the operators, which must be given the
  // same.
  void Build(const Model<S>& model, const PosedCamera& view, const double background[3], ViewWorkspace<S>& workspace);

  const PosedCamera& camera() const { return camera_; }
  Index num_pixels() const { return Index{camera_.width} * camera_.height; }
  // Number of splats seen, and of (splat, tile) pairs.
  Index num_splats() const { return splats_.size(); }
  Index num_pairs() const { return bins_.num_pairs(); }
  // rank_of[i]: place of Gaussian i in the order of depth, or -1 if not seen.
  HostSpan<const std::int32_t> rank_of() const { return rank_of_; }
  HostSpan<const Splat<S>> splats() const { return splats_; }

  // For RasterKernels; valid until the next Build.
  TileLists<S> Lists() const;
  // What a raster pass over this view visits; takes about as long as Render.
  VisitCounts CountVisits() const;
  // image[3 * num_pixels], planar.
  void Render(S* image) const;
  Index num_tiles() const { return bins_.num_tiles(); }
  // Keeps the raster's Jacobian until the next Build, for ApplyJ and AddJT to take their products from. image: from
  // Render. Both then err as JacobianCache says.
  void CacheJacobian(const S* image, CacheFormat format, ViewWorkspace<S>& /*workspace*/) {
    cache_.Build(Lists(), bins_, image, format);
  }
  const JacobianCache<S>& cache() const { return cache_; }
  // d_image = J dx; dx laid out as x.
  void ApplyJ(const Model<S>& model, const S* dx, S* d_image, ViewWorkspace<S>& workspace) const;
  // Render and ApplyJ at once. Without a cache.
  void RenderAndApplyJ(const Model<S>& model, const S* dx, S* image, S* d_image, ViewWorkspace<S>& workspace) const;
  // g += J^T u. image: from Render.
  void AddJT(const Model<S>& model, const S* image, const S* u, S* g, ViewWorkspace<S>& workspace) const;
  // The tangents of the splats, by rank, that dx makes; in workspace.splat_sums.
  SplatTangent<S>* ProjectTangents(const Model<S>& model, const S* dx, ViewWorkspace<S>& workspace) const;
  // The part of these between splats and image, J_raster, for what moves splats otherwise than their parameters do:
  // d_image = J_raster tangents, by rank; and J_raster^T u by rank, in the workspace.
  void ApplyRasterJ(const SplatTangent<S>* tangents, S* d_image) const;
  const SplatTangent<S>* ApplyRasterJT(const S* image, const S* u, ViewWorkspace<S>& workspace) const;
  // blocks and sh_diagonal += the blocks of J^T diag(omega) J (ProjectKernels::gram), omega >= 0 planar as the image.
  void AddGram(const Model<S>& model, const S* image, const S* omega, S* blocks, S* sh_diagonal,
               ViewWorkspace<S>& workspace) const;
  // rises[i] += that of the loss without Gaussian i, for each that is seen (loss_passes.h). loss.rendered: from
  // Render.
  void AddRemovals(const LinearizedLoss<S>& loss, double* rises, ViewWorkspace<S>& workspace) const;
  // Of the splats, by rank; in the workspace, until the next call.
  const ColorCurvature<S>* ColorCurvatures(const LinearizedLoss<S>& loss, ViewWorkspace<S>& workspace) const;
  // rises[i] += those of Gaussian i with other colours, for each that is seen; recolor(i): a Recolors<S>.
  template <class Recolor>
  void AddRecolors(const LinearizedLoss<S>& loss, const Recolor& recolor, RecolorRises<double>* rises,
                   ViewWorkspace<S>& workspace) const {
    workspace.recolors.ResizeForOverwrite(num_splats());
    ParallelFor(rank_of_.size(), 1024, [&](Index i) {
      if (rank_of_[i] >= 0) workspace.recolors[rank_of_[i]] = recolor(i);
    });
    SumRecolors(loss, rises, workspace);
  }

 private:
  // By workspace.recolors.
  void SumRecolors(const LinearizedLoss<S>& loss, RecolorRises<double>* rises, ViewWorkspace<S>& workspace) const;

  PosedCamera camera_{};
  S background_[3]{};
  HostBuffer<Splat<S>> splats_;
  HostBuffer<std::int32_t> rank_of_;
  TileBins bins_;
  JacobianCache<S> cache_;
};

}  // namespace vesta::splat
