// SPDX-License-Identifier: Apache-2.0
// The derivatives of a view's image by its own unknowns, held as images, and the curvature of the view's cost by them.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "kernels/core/block_diagonal.h"
#include "kernels/core/hd.h"
#include "kernels/core/span.h"
#include "kernels/gaussian_splatting/view/splat_view.h"
#include "kernels/image/photometric_loss.h"
#include "problems/gaussian_splatting/model/splat_backend.h"
#include "splatting/cameras/unknowns/view_unknowns.h"

namespace vesta::gs {

// A matrix from steps of a view (FreeUnknowns) to images of 3 planes. Each channel has a gain and an offset of its own,
// so a gain's column and those of the other two channels' make one image, and likewise the offsets': with the pose's
// six and the lens's four there are twelve at most. W treats channels by themselves too, so W times the matrix is one
// of the same form. In the memory of B.
template <class B>
class ViewColumns {
 public:
  using VectorView = typename B::VectorView;
  using ConstVectorView = typename B::ConstVectorView;

  ViewColumns() = default;
  // To be filled.
  ViewColumns(const FreeUnknowns& free, const ImageShape& shape) : free_(free), shape_(shape) {
    images_.ResizeForOverwrite(NumImages(free) * shape.NumValues());
  }
  static Index NumImages(const FreeUnknowns& free) {
    return free.pose_tangent() + (free.color ? 2 : 0) + free.lens_tangent();
  }

  const FreeUnknowns& free() const { return free_; }
  const ImageShape& shape() const { return shape_; }
  bool empty() const { return images_.empty(); }
  int num_images() const { return static_cast<int>(NumImages(free_)); }
  // First the pose's, then the gains', then the offsets', then the lens's.
  VectorView image(int k) { return images_.view().subspan(k * shape_.NumValues(), shape_.NumValues()); }
  ConstVectorView image(int k) const { return images_.view().subspan(k * shape_.NumValues(), shape_.NumValues()); }
  // Of a step, the number that image k is of in that channel.
  int Place(int k, int channel) const;

  // g[free.num_tangent()] = columns^T u, summed in double; u an image, on a device of its scalars.
  template <class U>
  void Project(const U* u, double* g) const;
  // u += scale columns v, v[free.num_tangent()].
  template <class U>
  void Add(double scale, const double* v, U* u) const;

 private:
  FreeUnknowns free_;
  ImageShape shape_{};
  typename B::Vector images_;
};

// The derivatives of the image that is shown, color of `rendered`, by the view's unknowns; zero where the target's mask
// leaves pixels out. moves: MovesOf the view. Of this and what follows, bodies are in view_columns.inl.
template <class B>
ViewColumns<B> ColumnsOf(const FreeUnknowns& free, const AffineColor& color, const TargetView<B>& target,
                         typename B::ConstVectorView rendered, typename B::ConstVectorView moves);
// The derivatives of the image of a view by the numbers of its pose and of its lens that are free, one after the other.
template <class B>
typename B::Vector MovesOf(const FreeUnknowns& free, const typename SplatBackend<B>::SplatView& view,
                           const splat::Model<typename B::Scalar>& model,
                           typename SplatBackend<B>::Workspace& workspace);

// J^T W J, square, free.num_tangent() numbers a side. weighted: unless null becomes W J.
template <class B>
std::vector<double> WeightedGram(const ViewColumns<B>& J, typename SplatBackend<B>::Loss& loss,
                                 const typename SplatBackend<B>::Loss::Linearization& W,
                                 ViewColumns<B>* weighted = nullptr);

// A block of the engine from the whole of a symmetric matrix, n numbers a side: number `block` of so many of its group.
template <class T>
void FillBlock(const std::vector<double>& H, int n, Index block, Index blocks, HostSpan<T> values) {
  for (int row = 0; row < n; ++row) {
    for (int col = 0; col <= row; ++col) {
      const auto at = static_cast<std::size_t>(row) * static_cast<std::size_t>(n) + static_cast<std::size_t>(col);
      values[PackedLower(row, col) * blocks + block] = static_cast<T>(H[at]);
    }
  }
}

// By pixel of a channel: sum += scale (factors[0] column 0 + ...), added up in double.
template <class S, class U>
struct AddColumns {
  static constexpr int kMost = 12;  // columns

  double scale;
  int columns;
  Index stride;  // from a column to the next, values
  const S* first;
  U* sum;
  double factors[kMost];

  VESTA_HD void operator()(Index i) const {
    double product = 0;
    for (int k = 0; k < columns; ++k) product += factors[k] * static_cast<double>(first[k * stride + i]);
    sum[i] += static_cast<U>(scale * product);
  }
};

// The curvature of a view's cost by its own unknowns, in the memory of B.
// H = J^T W J of the view as it stands, without an exposure, by the default weights: square, free.num_tangent() numbers
// a side. Body in view_columns.inl.
template <class B>
std::vector<double> ViewCurvature(const FreeUnknowns& free, const std::array<double, 3>& background,
                                  const splat::Model<float>& model, const TargetView<B>& target);

}  // namespace vesta::gs
