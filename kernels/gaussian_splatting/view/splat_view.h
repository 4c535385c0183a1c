// SPDX-License-Identifier: Apache-2.0
// One view of a model: its visible splats in depth order, and the operators between parameters and image.
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

// Scratch memory that several views may share, one after the other. Undefined between calls, unless stated otherwise.
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

  // Bytes that SplatView::Build needs for a view.
  static double BuildBytes(const ViewCounts& view, double gaussians) {
    return kSpareCapacity * gaussians * (sizeof(std::uint32_t) + sizeof(Splat<S>)) + 2 * sizeof(KeyValue) * view.splats;
  }
  // Bytes for products with J and J^T.
  static double ProductBytes(const ViewCounts& view) {
    return kSpareCapacity * (view.splats + view.pairs) * sizeof(SplatTangent<S>);
  }
  // Additional bytes if the Jacobian is cached.
  static double CacheBytes(const ViewCounts& view) { return 3 * sizeof(S) * kTileSize * kTileSize * view.tiles; }
  // Bytes for AddGram.
  static double GramBytes(const ViewCounts& view) {
    return kSpareCapacity * (view.splats + view.pairs) * sizeof(SplatGram<S>);
  }
};

// The image of a model in a view. The model's parameters x determine the splats y, and y determines the image. The
// Jacobian J of the image is therefore J_raster J_project, both at the x given to Build. The rank of a splat is its
// index in depth order. Results are bit-identical for any number of threads.
template <class S>
class SplatView {
 public:
  using Cache = JacobianCache<S>;

  // Bytes of a view without a cache.
  static double Bytes(const ViewCounts& view, double gaussians) {
    return sizeof(Splat<S>) * view.splats + sizeof(std::int32_t) * gaussians + TileBins::Bytes(view);
  }

  // Projects the Gaussians, sorts the visible ones by (depth, index), and assigns them to tiles. Discards a cached
  // Jacobian. The operators below need the same model with unchanged x.
  void Build(const Model<S>& model, const PosedCamera& view, const double background[3], ViewWorkspace<S>& workspace);

  const PosedCamera& camera() const { return camera_; }
  Index num_pixels() const { return Index{camera_.width} * camera_.height; }
  // Visible splats, and (splat, tile) pairs.
  Index num_splats() const { return splats_.size(); }
  Index num_pairs() const { return bins_.num_pairs(); }
  // rank_of[i]: rank of Gaussian i, or -1 if it is not visible.
  HostSpan<const std::int32_t> rank_of() const { return rank_of_; }
  HostSpan<const Splat<S>> splats() const { return splats_; }

  // For RasterKernels; valid until the next Build.
  TileLists<S> Lists() const;
  // Counts the work of a raster pass, in about the time of Render.
  VisitCounts CountVisits() const;
  // image: 3 planes (red, green, blue) of num_pixels values.
  void Render(S* image) const;
  Index num_tiles() const { return bins_.num_tiles(); }
  // Stores J_raster until the next Build. All products with J_raster then use it, with the errors given in
  // JacobianCache. image: from Render.
  void CacheJacobian(const S* image, CacheFormat format, ViewWorkspace<S>& /*workspace*/) {
    cache_.Build(Lists(), bins_, image, format);
  }
  const JacobianCache<S>& cache() const { return cache_; }
  // d_image = J dx; dx has the layout of x.
  void ApplyJ(const Model<S>& model, const S* dx, S* d_image, ViewWorkspace<S>& workspace) const;
  // Render and ApplyJ together. Throws Error if the Jacobian is cached.
  void RenderAndApplyJ(const Model<S>& model, const S* dx, S* image, S* d_image, ViewWorkspace<S>& workspace) const;
  // g += J^T u. image: from Render.
  void AddJT(const Model<S>& model, const S* image, const S* u, S* g, ViewWorkspace<S>& workspace) const;
  // Returns J_project dx, the tangents of the splats, by rank, in workspace.splat_sums.
  SplatTangent<S>* ProjectTangents(const Model<S>& model, const S* dx, ViewWorkspace<S>& workspace) const;
  // Products with J_raster alone, for derivatives with respect to other parameters, such as the camera. d_image =
  // J_raster tangents. tangents: by rank.
  void ApplyRasterJ(const SplatTangent<S>* tangents, S* d_image) const;
  // Returns J_raster^T u, the cotangents of the splats, by rank, in workspace.splat_sums. image: from Render.
  const SplatTangent<S>* ApplyRasterJT(const S* image, const S* u, ViewWorkspace<S>& workspace) const;
  // Adds parts of J^T diag(omega) J. Adds each Gaussian's diagonal block of the geometric attributes to `blocks`, and
  // the diagonal of the SH attributes to `sh_diagonal` (layouts: ProjectKernels::gram). omega: 3 planes like the image,
  // >= 0. image: from Render.
  void AddGram(const Model<S>& model, const S* image, const S* omega, S* blocks, S* sh_diagonal,
               ViewWorkspace<S>& workspace) const;
  // For each visible Gaussian i: adds to rises[i] the rise of the loss if only Gaussian i is removed (loss_passes.h).
  // loss.rendered: from Render.
  void AddRemovalRises(const LinearizedLoss<S>& loss, double* rises, ViewWorkspace<S>& workspace) const;
  // Returns, by rank, the second derivative of the loss with respect to the colour of each splat. It is valid until the
  // next call.
  const ColorCurvature<S>* ColorCurvatures(const LinearizedLoss<S>& loss, ViewWorkspace<S>& workspace) const;
  // recolor(i): kRecolors other colours for Gaussian i. For each visible Gaussian i and each of these colours: adds to
  // rises[i] the rise of the loss if only Gaussian i has this colour.
  template <class Recolor>
  void AddRecolorRises(const LinearizedLoss<S>& loss, const Recolor& recolor, RecolorRises<double>* rises,
                       ViewWorkspace<S>& workspace) const {
    workspace.recolors.ResizeForOverwrite(num_splats());
    ParallelFor(rank_of_.size(), 1024, [&](Index i) {
      if (rank_of_[i] >= 0) workspace.recolors[rank_of_[i]] = recolor(i);
    });
    SumRecolorRises(loss, rises, workspace);
  }

 private:
  // Uses workspace.recolors.
  void SumRecolorRises(const LinearizedLoss<S>& loss, RecolorRises<double>* rises, ViewWorkspace<S>& workspace) const;

  PosedCamera camera_{};
  S background_[3]{};
  HostBuffer<Splat<S>> splats_;
  HostBuffer<std::int32_t> rank_of_;
  TileBins bins_;
  JacobianCache<S> cache_;
};

}  // namespace vesta::splat
