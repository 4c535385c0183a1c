// SPDX-License-Identifier: Apache-2.0
// Projection of Gaussians to a view, and the derivatives of the projection: the functions in ProjectKernels. They
// process a block of neighbouring Gaussians, one per SIMD lane. On a GPU, a block is one Gaussian.
#pragma once

#include <bit>
#include <cmath>
#include <limits>

#include "kernels/core/packed.h"
#include "kernels/gaussian_splatting/formulas/color.h"
#include "kernels/gaussian_splatting/formulas/layout.h"
#include "kernels/gaussian_splatting/formulas/pixel_steps.h"
#include "kernels/gaussian_splatting/formulas/project.h"
#include "kernels/gaussian_splatting/projection/project_kernels.h"
#include "kernels/math/dual.h"
#include "kernels/math/scalar.h"

namespace vesta::splat {
inline namespace VESTA_ISA {

// ModelLayout::Offset of all attributes up to an SH degree. The host has a table of the offsets. A GPU computes an
// offset each time, because a table would not be in registers.
template <class V, int Degree>
class AttributeOffsets {
 public:
  VESTA_HD explicit AttributeOffsets(const ModelLayout& layout) : rows_{layout.count}, base_{} {
    for (int band = 1; band <= Degree; ++band) {
      rows_[band] = layout.WithBand(band);
      base_[band] = base_[band - 1] + FirstOfBand(band) * (rows_[band - 1] - rows_[band]);
    }
    if constexpr (kIsTable) {
      for (int a = 0; a < NumAttributes(Degree); ++a) table_[a] = Computed(a);
    }
  }
  VESTA_HD std::int64_t operator()(int attribute) const {
    if constexpr (kIsTable) {
      return table_[attribute];
    } else {
      return Computed(attribute);
    }
  }

 private:
  static constexpr bool kIsTable = Lanes<V>::kWidth > 1;

  VESTA_HD std::int64_t Computed(int attribute) const {
    const int band = BandOf(attribute);
    return base_[band] + attribute * rows_[band];
  }

  std::int64_t rows_[Degree + 1], base_[Degree + 1];
  std::int64_t table_[kIsTable ? NumAttributes(Degree) : 1];
};

// A block of Gaussians i .. i + n - 1 in a structure of arrays. A row is the array of one attribute. If n is less than
// the number of lanes, Load zeroes the other lanes, and Add does not write them.
template <class V, class S>
struct Block {
  using L = Lanes<V>;
  std::int64_t i;
  int n;

  VESTA_HD Block(std::int64_t first, std::int64_t end)
      : i(first), n(static_cast<int>(end - first < L::kWidth ? end - first : L::kWidth)) {}
  // Prefetches the first `rows` rows of a later block, unless this block reaches beyond `end`. offset(r): first index
  // of row r. The hardware prefetcher cannot follow so many memory streams.
  template <class Offset>
  VESTA_HD void PrefetchAhead(const S* x, const Offset& offset, int rows, std::int64_t end) const {
    if constexpr (L::kWidth > 1) {  // not on a device, where neighbouring threads read together
      constexpr int kBlocks = 2;
      if (i + (kBlocks + 1) * L::kWidth > end) return;
      for (int r = 0; r < rows; ++r) __builtin_prefetch(x + offset(r) + i + kBlocks * L::kWidth);
    }
  }
  // row: first value of a row.
  VESTA_HD V Load(const S* row) const {
    const S* p = row + i;
    if (n == L::kWidth) return L::Load(p);
    alignas(64) S lane[L::kWidth] = {};
    for (int k = 0; k < n; ++k) lane[k] = p[k];
    return L::Load(lane);
  }
  VESTA_HD void Add(S* row, const V& value) const {
    S* p = row + i;
    if (n == L::kWidth) return L::Store(p, L::Load(p) + value);
    alignas(64) S lane[L::kWidth];
    L::Store(lane, value);
    for (int k = 0; k < n; ++k) p[k] += lane[k];
  }
};

// Geometric attributes of a block, and their projection.
template <class V, class L>
struct ProjectedBlock {
  V mean[3], log_scale[3], quaternion[4], opacity;
  ProjectionState<L, V> state;
  SplatShape<V> shape;

  // load(a) returns attribute a of the block.
  template <class S, class Load>
  VESTA_HD ProjectedBlock(const CameraConstants<S, L>& camera, const Load& load) {
    for (int k = 0; k < 3; ++k) mean[k] = load(kMean + k), log_scale[k] = load(kLogScale + k);
    for (int k = 0; k < 4; ++k) quaternion[k] = load(kQuaternion + k);
    opacity = Sigmoid(load(kOpacity));
    shape = Project(camera, mean, log_scale, quaternion, state);
  }
};

// Visible Gaussians of a block. rank_of[i]: index of Gaussian i in depth order, or -1 if not visible.
template <class V, class S>
VESTA_HD typename Lanes<V>::Mask VisibleLanes(const Block<V, S>& block, const std::int32_t* rank_of) {
  bool is_seen[Lanes<V>::kWidth];
  for (int lane = 0; lane < Lanes<V>::kWidth; ++lane) is_seen[lane] = lane < block.n && rank_of[block.i + lane] >= 0;
  return Lanes<V>::LoadMask(is_seen);
}

// out[k] = scalar k of the record of each Gaussian of the block; 0 if not visible. fields(rank) points to the N scalars
// of the record.
template <int N, class V, class S, class Fields>
VESTA_HD void GatherRecords(const Block<V, S>& block, const std::int32_t* rank_of, const Fields& fields, V* out) {
  alignas(64) S lanes[N][Lanes<V>::kWidth] = {};
  for (int lane = 0; lane < block.n; ++lane) {
    const std::int32_t rank = rank_of[block.i + lane];
    if (rank < 0) continue;
    const S* from = fields(rank);
    for (int k = 0; k < N; ++k) lanes[k][lane] = from[k];
  }
  for (int k = 0; k < N; ++k) out[k] = Lanes<V>::Load(lanes[k]);
}

// The inverse of GatherRecords, for the visible Gaussians.
template <int N, class V, class S, class Fields>
VESTA_HD void ScatterRecords(const Block<V, S>& block, const std::int32_t* rank_of, const Fields& fields,
                             const V* values) {
  alignas(64) S lanes[N][Lanes<V>::kWidth];
  for (int k = 0; k < N; ++k) Lanes<V>::Store(lanes[k], values[k]);
  for (int lane = 0; lane < block.n; ++lane) {
    const std::int32_t rank = rank_of[block.i + lane];
    if (rank < 0) continue;
    S* to = fields(rank);
    for (int k = 0; k < N; ++k) to[k] = lanes[k][lane];
  }
}

template <class V>
VESTA_HD V Log2(const V& x) {
  using std::log2;
  return log2(x);
}

template <class V, class S, int Degree, class L>
VESTA_HD void ProjectRange(const Model<S>& model, const CameraConstants<S, L>& camera, std::int64_t begin,
                           std::int64_t end, std::uint32_t* key, Splat<S>* splats) {
  using Lane = Lanes<V>;
  using std::sqrt;
  const V floor_opacity(static_cast<S>(kAlphaFloor)), width(camera.width), height(camera.height),
      huge(static_cast<S>(1e15)), largest_det(static_cast<S>(kLargestDet));
  const AttributeOffsets<V, Degree> at(model);
  for (std::int64_t i = begin; i < end; i += Lane::kWidth) {
    const Block<V, S> block(i, end);
    block.PrefetchAhead(model.x, at, NumAttributes(Degree), model.count);
    const auto load = [&](int a) { return block.Load(model.x + at(a)); };
    const ProjectedBlock<V, L> b(camera, load);
    const SplatShape<V>& shape = b.shape;
    // Slightly enlarged. This is harmless, because raster passes use the support only to skip pixels.
    const V opacity = b.opacity * shape.compensation, log2_opacity = Log2(Max(opacity, floor_opacity));
    const V support =
        V(static_cast<S>(1.0001)) * (log2_opacity - V(static_cast<S>(kLog2AlphaFloor))) + V(static_cast<S>(1e-3));
    const V reach_x = sqrt(support * (V(1) / (shape.r * shape.r) + Square(shape.beta / shape.s)));
    const V reach_y = sqrt(support) / shape.s;
    // Comparisons with NaN are false, so non-finite Gaussians are skipped.
    const auto seen = (b.state.t[2] > V(camera.near)) & (opacity >= floor_opacity) & (shape.u + reach_x > V(0)) &
                      (shape.u - reach_x < width) & (shape.v + reach_y > V(0)) & (shape.v - reach_y < height) &
                      (shape.r > V(0)) & (shape.s > V(0)) & (shape.r < huge) & (reach_x < huge) & (reach_y < huge) &
                      (b.state.det < largest_det) & (b.state.t[2] < huge) & (shape.u > V(camera.u_lo)) &
                      (shape.u < V(camera.u_hi)) & (shape.v > V(camera.v_lo)) & (shape.v < V(camera.v_hi)) &
                      IsProjectionAccurate(camera.lens, b.state);
    bool is_seen[Lane::kWidth];
    Lane::StoreMask(is_seen, seen);
    for (int lane = 0; lane < block.n; ++lane) key[i + lane] = kInvisible;
    if (!Lane::Any(seen)) continue;

    V dir[3], basis[ShCoefficients(Degree)], color[3];
    ViewDirection(camera.centre, b.mean, dir);
    ShBasis<Degree>(dir[0], dir[1], dir[2], basis);
    ShColor<Degree>(
        basis, [&](int a) { return load(kSh + a); }, color);
    const auto finite = (color[0] < huge) & (color[1] < huge) & (color[2] < huge) & (color[0] > -huge) &
                        (color[1] > -huge) & (color[2] > -huge);
    Lane::StoreMask(is_seen, seen & finite);

    constexpr int kFields = 11;
    alignas(64) S field[kFields][Lane::kWidth], depth[Lane::kWidth];
    const V values[kFields] = {shape.u,
                               shape.v,
                               shape.r,
                               shape.s,
                               shape.beta,
                               log2_opacity,
                               support,
                               Max(color[0], V(0)),
                               Max(color[1], V(0)),
                               Max(color[2], V(0)),
                               V(1) / shape.r};
    for (int k = 0; k < kFields; ++k) Lane::Store(field[k], values[k]);
    Lane::Store(depth, b.state.t[2]);
    for (int lane = 0; lane < block.n; ++lane) {
      if (!is_seen[lane]) continue;
      key[i + lane] = std::bit_cast<std::uint32_t>(static_cast<float>(depth[lane]));
      splats[i + lane] = {field[0][lane],  field[1][lane],
                          field[2][lane],  field[3][lane],
                          field[4][lane],  field[5][lane],
                          field[6][lane],  {field[7][lane], field[8][lane], field[9][lane]},
                          field[10][lane], {}};
    }
  }
}

// Computes the tangents of the splats from the parameters and their derivatives, for constant opacities. colored: the
// mean from which the viewing direction of the colour is computed. If the camera rotates, the derivatives of `colored`
// and `mean` differ. sh: as in ShColor.
template <int Degree, class S, class L, class V, class Sh>
VESTA_HD void TangentOfSplat(const CameraConstants<S, L>& camera, const Dual<V> mean[3], const Dual<V> log_scale[3],
                             const Dual<V> quaternion[4], const Dual<V> colored[3], const Sh& sh, V w[kSplatTangent]) {
  using D = Dual<V>;
  ProjectionState<L, D> state;
  const SplatShape<D> dual = Project(camera, mean, log_scale, quaternion, state);
  const SplatShape<V> shape = {dual.u.a, dual.v.a, dual.r.a, dual.s.a, dual.beta.a};
  const SplatShape<V> d_shape = {dual.u.v, dual.v.v, dual.r.v, dual.s.v, dual.beta.v};
  WhitenTangent(shape, d_shape, w);
  w[kLambda] = camera.antialiased ? dual.compensation.v / dual.compensation.a : V(0);
  D dir[3], basis[ShCoefficients(Degree)], color[3];
  ViewDirection(camera.centre, colored, dir);
  ShBasis<Degree>(dir[0], dir[1], dir[2], basis);
  ShColor<Degree>(basis, sh, color);
  for (int c = 0; c < 3; ++c) w[kColor + c] = Select(color[c].a > V(0), color[c].v, V(0));
}

template <class V, class S, int Degree, class L>
VESTA_HD void TangentRange(const Model<S>& model, const CameraConstants<S, L>& camera, std::int64_t begin,
                           std::int64_t end, const std::int32_t* rank_of, const S* dx, SplatTangent<S>* tangents) {
  using D = Dual<V>;
  const AttributeOffsets<V, Degree> at(model);
  for (std::int64_t i = begin; i < end; i += Lanes<V>::kWidth) {
    const Block<V, S> block(i, end);
    block.PrefetchAhead(model.x, at, NumAttributes(Degree), model.count);
    block.PrefetchAhead(dx, at, NumAttributes(Degree), model.count);
    if (!Lanes<V>::Any(VisibleLanes(block, rank_of))) continue;
    const auto load = [&](int a) { return D(block.Load(model.x + at(a)), block.Load(dx + at(a))); };
    D mean[3], log_scale[3], quaternion[4];
    for (int k = 0; k < 3; ++k) mean[k] = load(kMean + k), log_scale[k] = load(kLogScale + k);
    for (int k = 0; k < 4; ++k) quaternion[k] = load(kQuaternion + k);
    V w[kSplatTangent];
    TangentOfSplat<Degree>(
        camera, mean, log_scale, quaternion, mean, [&](int a) { return load(kSh + a); }, w);
    const V opacity = Sigmoid(block.Load(model.x + at(kOpacity)));
    w[kLambda] = Fma(V(1) - opacity, block.Load(dx + at(kOpacity)), w[kLambda]);
    ScatterRecords<kSplatTangent>(
        block, rank_of, [&](std::int32_t rank) { return tangents[rank].w; }, w);
  }
}

// Colours of a block of Gaussians, for the adjoint and the Gram matrix.
template <class V, class S, int Degree>
struct ColorBlock {
  V dir[3], inv_distance, basis[ShCoefficients(Degree)], sh[3 * ShCoefficients(Degree)], color[3];

  template <class Load>
  VESTA_HD ColorBlock(const S centre[3], const Load& load, const V mean[3]) {
    inv_distance = ViewDirection(centre, mean, dir);
    ShBasis<Degree>(dir[0], dir[1], dir[2], basis);
    for (int a = 0; a < 3 * ShCoefficients(Degree); ++a) sh[a] = load(kSh + a);
    ShColor<Degree>(
        basis, [&](int a) { return sh[a]; }, color);
  }
  // Returns `value`, or 0 where channel c of the colour is clamped.
  VESTA_HD V Masked(int c, const V& value) const { return Select(color[c] > V(0), value, V(0)); }
  VESTA_HD void MeanAdjoint(const V color_bar[3], V mean_bar[3]) const {
    ShColorMeanAdjoint<Degree>(
        dir, inv_distance, [&](int a) { return sh[a]; }, color_bar, mean_bar);
  }
};

template <class V, class S, int Degree, class L>
VESTA_HD void AdjointRange(const Model<S>& model, const CameraConstants<S, L>& camera, std::int64_t begin,
                           std::int64_t end, const std::int32_t* rank_of, const SplatTangent<S>* cotangents, S* g) {
  const AttributeOffsets<V, Degree> at(model);
  for (std::int64_t i = begin; i < end; i += Lanes<V>::kWidth) {
    const Block<V, S> block(i, end);
    block.PrefetchAhead(model.x, at, NumAttributes(Degree), model.count);
    block.PrefetchAhead(g, at, NumAttributes(Degree), model.count);
    const auto seen = VisibleLanes(block, rank_of);
    if (!Lanes<V>::Any(seen)) continue;
    V w_bar[kSplatTangent];
    GatherRecords<kSplatTangent>(
        block, rank_of, [&](std::int32_t rank) { return cotangents[rank].w; }, w_bar);
    const auto load = [&](int a) { return block.Load(model.x + at(a)); };
    const ProjectedBlock<V, L> b(camera, load);
    const ColorBlock<V, S, Degree> color(camera.centre, load, b.mean);
    V mean_bar[3], log_scale_bar[3], quaternion_bar[4];
    ProjectAdjoint(camera, b.quaternion, b.state, b.shape, w_bar, mean_bar, log_scale_bar, quaternion_bar);
    V color_bar[3];
    for (int c = 0; c < 3; ++c) color_bar[c] = color.Masked(c, w_bar[kColor + c]);
    color.MeanAdjoint(color_bar, mean_bar);

    // Lanes of invisible Gaussians may contain any value (for example if the mean is behind the camera).
    const auto add = [&](int a, const V& value) { block.Add(g + at(a), Select(seen, value, V(0))); };
    for (int k = 0; k < 3; ++k) add(kMean + k, mean_bar[k]), add(kLogScale + k, log_scale_bar[k]);
    for (int k = 0; k < 4; ++k) add(kQuaternion + k, quaternion_bar[k]);
    add(kOpacity, (V(1) - b.opacity) * w_bar[kLambda]);
    for (int k = 0; k < ShCoefficients(Degree); ++k) {
      for (int c = 0; c < 3; ++c) add(kSh + 3 * k + c, color.basis[k] * color_bar[c]);
    }
  }
}

// Computes the Gram matrix of a splat from its sums (SplatGram in types.h).
template <class V>
VESTA_HD void GramMatrix(const V m[kGramSums], V G[kSplatTangent][kSplatTangent]) {
  const V* cross = m + kMoments4;
  const V* color = cross + 3 * kMoments2;
  for (int i = 0; i < kSplatShape; ++i) {
    for (int j = 0; j <= i; ++j) {
      const V value = m[MonomialIndex(PowerP(i) + PowerP(j), PowerQ(i) + PowerQ(j))];
      G[i][j] = G[j][i] = (i == kLambda) != (j == kLambda) ? -value : value;
    }
    for (int c = 0; c < 3; ++c) {
      const V value = cross[c * kMoments2 + MonomialIndex(PowerP(i), PowerQ(i))];
      G[i][kColor + c] = G[kColor + c][i] = i == kLambda ? value : -value;
    }
  }
  for (int c = 0; c < 3; ++c) {
    for (int d = 0; d < 3; ++d) G[kColor + c][kColor + d] = c == d ? color[c] : V(0);
  }
}

template <class V, class S, int Degree, class L>
VESTA_HD void GramRange(const Model<S>& model, const CameraConstants<S, L>& camera, std::int64_t begin,
                        std::int64_t end, const std::int32_t* rank_of, const SplatGram<S>* grams, S* blocks,
                        S* sh_diagonal) {
  const AttributeOffsets<V, Degree> at(model);
  const auto of_block = [&](std::int64_t entry) { return entry * model.count; };
  for (std::int64_t i = begin; i < end; i += Lanes<V>::kWidth) {
    const Block<V, S> block(i, end);
    block.PrefetchAhead(model.x, at, NumAttributes(Degree), model.count);
    block.PrefetchAhead(blocks, of_block, PackedSize(kGeometry), model.count);
    const auto seen = VisibleLanes(block, rank_of);
    if (!Lanes<V>::Any(seen)) continue;
    V m[kGramSums], G[kSplatTangent][kSplatTangent];
    GatherRecords<kGramSums>(
        block, rank_of, [&](std::int32_t rank) { return grams[rank].m; }, m);
    GramMatrix(m, G);
    const auto load = [&](int a) { return block.Load(model.x + at(a)); };
    const ProjectedBlock<V, L> b(camera, load);
    const ColorBlock<V, S, Degree> color(camera.centre, load, b.mean);

    // K = d(splat tangent) / d(geometric attributes). Each row is the adjoint of a unit cotangent.
    V K[kSplatTangent][kGeometry];
    for (auto& row : K) {
      for (V& value : row) value = V(0);
    }
    for (int row = 0; row < (camera.antialiased ? kSplatShape : kLambda); ++row) {
      V unit[kSplatShape];
      for (int k = 0; k < kSplatShape; ++k) unit[k] = V(static_cast<S>(k == row ? 1 : 0));
      ProjectAdjoint(camera, b.quaternion, b.state, b.shape, unit, &K[row][kMean], &K[row][kLogScale],
                     &K[row][kQuaternion]);
    }
    K[kLambda][kOpacity] = V(1) - b.opacity;
    for (int c = 0; c < 3; ++c) {
      V unit[3] = {V(0), V(0), V(0)};
      unit[c] = color.Masked(c, V(1));
      color.MeanAdjoint(unit, &K[kColor + c][kMean]);
    }

    for (int col = 0; col < kGeometry; ++col) {
      V GK[kSplatTangent];
      for (int r = 0; r < kSplatTangent; ++r) {
        GK[r] = V(0);
        for (int k = 0; k < kSplatTangent; ++k) GK[r] = Fma(G[r][k], K[k][col], GK[r]);
      }
      for (int row = col; row < kGeometry; ++row) {
        V value(0);
        for (int k = 0; k < kSplatTangent; ++k) value = Fma(K[k][row], GK[k], value);
        // Rounding may make a diagonal entry negative.
        if (row == col) value = Max(value, V(0));
        block.Add(blocks + of_block(PackedLower(row, col)), Select(seen, value, V(0)));
      }
    }
    for (int c = 0; c < 3; ++c) {
      const V weight = color.Masked(c, G[kColor + c][kColor + c]);
      for (int k = 0; k < ShCoefficients(Degree); ++k) {
        // Masked last, because the basis may be NaN in the lane of an invisible Gaussian.
        block.Add(sh_diagonal + (at(kSh + 3 * k + c) - at(kSh)),
                  Select(seen, weight * color.basis[k] * color.basis[k], V(0)));
      }
    }
  }
}

template <class V, class S, int Degree>
constexpr ProjectKernels<S> ProjectKernelsOfDegree() {
  using Index = std::int64_t;
  return {
      [](const Model<S>& model, const PosedCamera& view, Index begin, Index end, std::uint32_t* key, Splat<S>* splats) {
        WithConstants<S>(
            view, [&](const auto& camera) { ProjectRange<V, S, Degree>(model, camera, begin, end, key, splats); });
      },
      [](const Model<S>& model, const PosedCamera& view, Index begin, Index end, const std::int32_t* rank_of,
         const S* dx, SplatTangent<S>* tangents) {
        WithConstants<S>(view, [&](const auto& camera) {
          TangentRange<V, S, Degree>(model, camera, begin, end, rank_of, dx, tangents);
        });
      },
      [](const Model<S>& model, const PosedCamera& view, Index begin, Index end, const std::int32_t* rank_of,
         const SplatTangent<S>* cotangents, S* g) {
        WithConstants<S>(view, [&](const auto& camera) {
          AdjointRange<V, S, Degree>(model, camera, begin, end, rank_of, cotangents, g);
        });
      },
      [](const Model<S>& model, const PosedCamera& view, Index begin, Index end, const std::int32_t* rank_of,
         const SplatGram<S>* grams, S* blocks, S* sh_diagonal) {
        WithConstants<S>(view, [&](const auto& camera) {
          GramRange<V, S, Degree>(model, camera, begin, end, rank_of, grams, blocks, sh_diagonal);
        });
      }};
}

// kernels[d] processes Gaussians of SH degree d.
template <class V, class S>
inline constexpr ProjectKernels<S> kProjectKernels[4] = {
    ProjectKernelsOfDegree<V, S, 0>(), ProjectKernelsOfDegree<V, S, 1>(), ProjectKernelsOfDegree<V, S, 2>(),
    ProjectKernelsOfDegree<V, S, 3>()};

}  // namespace VESTA_ISA
}  // namespace vesta::splat
