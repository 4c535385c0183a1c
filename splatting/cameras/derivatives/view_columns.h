// SPDX-License-Identifier: Apache-2.0
// The Jacobian J of a view's image with respect to its own unknowns (pose, exposure, lens), stored as images, and the
// Gauss-Newton curvature J^T W J of the view's cost. W is the curvature of the photometric loss.
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

// A matrix with one column per free unknown; each column is an image of three planes in the memory of backend B. A gain
// or offset affects one channel, so the three gains share an image, and the three offsets another. The pose has six
// images, the lens four. W does not mix channels, so W times this matrix has the same form.
template <class B>
class ViewColumns {
 public:
  using VectorView = typename B::VectorView;
  using ConstVectorView = typename B::ConstVectorView;

  ViewColumns() = default;
  // Does not initialise the images.
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
  // Order: pose, gains, offsets, lens.
  VectorView image(int k) { return images_.view().subspan(k * shape_.NumValues(), shape_.NumValues()); }
  ConstVectorView image(int k) const { return images_.view().subspan(k * shape_.NumValues(), shape_.NumValues()); }
  // Index in a step of the unknown whose column is channel `channel` of image k.
  int Place(int k, int channel) const;

  // g = columns^T u, for an image u; g has free.num_tangent() numbers and is summed in double. On a device u must have
  // the scalar type of B.
  template <class U>
  void Project(const U* u, double* g) const;
  // u += scale * columns * v; v has free.num_tangent() numbers.
  template <class U>
  void Add(double scale, const double* v, U* u) const;

 private:
  FreeUnknowns free_;
  ImageShape shape_{};
  typename B::Vector images_;
};

// Derivatives of the exposed image `color(rendered)` with respect to the free unknowns; zero at masked pixels.
// rendered: before the exposure. moves: derivatives of `rendered`, from CameraDerivativeImages. Defined, like the
// functions below, in view_columns.inl.
template <class B>
ViewColumns<B> ColumnsOf(const FreeUnknowns& free, const AffineColor& color, const TargetView<B>& target,
                         typename B::ConstVectorView rendered, typename B::ConstVectorView moves);
// Derivatives of the image before the exposure: one image per free number of the pose, then of the lens.
template <class B>
typename B::Vector CameraDerivativeImages(const FreeUnknowns& free, const typename SplatBackend<B>::SplatView& view,
                                          const splat::Model<typename B::Scalar>& model,
                                          typename SplatBackend<B>::Workspace& workspace);

// J^T W J: square, free.num_tangent() rows, row-major. Stores W J in `weighted` unless null.
template <class B>
std::vector<double> WeightedGram(const ViewColumns<B>& J, typename SplatBackend<B>::Loss& loss,
                                 const typename SplatBackend<B>::Loss::Linearization& W,
                                 ViewColumns<B>* weighted = nullptr);

// Copies a symmetric n x n matrix H (row-major) into block `block` of `blocks` interleaved blocks: entry e of the
// packed lower triangle (PackedLower) is at e * blocks + block.
template <class T>
void FillBlock(const std::vector<double>& H, int n, Index block, Index blocks, HostSpan<T> values) {
  for (int row = 0; row < n; ++row) {
    for (int col = 0; col <= row; ++col) {
      const auto at = static_cast<std::size_t>(row) * static_cast<std::size_t>(n) + static_cast<std::size_t>(col);
      values[PackedLower(row, col) * blocks + block] = static_cast<T>(H[at]);
    }
  }
}

// sum[i] += scale * (factors[0] * column 0 [i] + factors[1] * column 1 [i] + ...), in double.
template <class S, class U>
struct AddColumns {
  static constexpr int kMost = 12;

  double scale;
  int columns;
  Index stride;    // distance between columns, in values
  const S* first;  // column 0
  U* sum;
  double factors[kMost];

  VESTA_HD void operator()(Index i) const {
    double product = 0;
    for (int k = 0; k < columns; ++k) product += factors[k] * static_cast<double>(first[k * stride + i]);
    sum[i] += static_cast<U>(scale * product);
  }
};

// The curvature J^T W J at the view's current camera, without an exposure and with the default loss weights. Square,
// free.num_tangent() rows, row-major.
template <class B>
std::vector<double> ViewCurvature(const FreeUnknowns& free, const std::array<double, 3>& background,
                                  const splat::Model<float>& model, const TargetView<B>& target);

}  // namespace vesta::gs
