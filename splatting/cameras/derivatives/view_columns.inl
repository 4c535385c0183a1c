// SPDX-License-Identifier: Apache-2.0
// Definitions of view_columns.h for every memory space. Include after the camera derivatives of that space
// (kernels/gaussian_splatting/view/camera_jacobian.h or device_camera.h).
#pragma once

#include <algorithm>

#include "kernels/core/for_each.h"
#include "problems/gaussian_splatting/model/masked_loss.h"
#include "splatting/cameras/derivatives/image_products.h"
#include "splatting/cameras/derivatives/view_columns.h"
#include "splatting/cameras/unknowns/exposed_colors.h"

namespace vesta::gs {

template <class B>
int ViewColumns<B>::Place(int k, int channel) const {
  const int pose = free_.pose_tangent();
  if (k < pose) return k;
  if (!free_.color) return free_.Lens(k - pose);
  return k == pose ? free_.Gain(channel) : k == pose + 1 ? free_.Offset(channel) : free_.Lens(k - pose - 2);
}

template <class B>
template <class U>
void ViewColumns<B>::Project(const U* u, double* g) const {
  using Plane = Span<const U, typename B::Space>;
  const Index n = shape_.PlaneSize();
  constexpr int kChannels = ImageShape::kChannels;
  ImageProducts<B> products(kChannels * num_images());
  for (int k = 0; k < num_images(); ++k) {
    for (int c = 0; c < kChannels; ++c) products.AddDot(image(k).subspan(c * n, n), Plane(u + c * n, n));
  }
  const std::vector<double> sums = products.Read();
  auto sum = sums.begin();
  std::fill_n(g, free_.num_tangent(), 0.0);
  for (int k = 0; k < num_images(); ++k) {
    for (int c = 0; c < kChannels; ++c) g[Place(k, c)] += *sum++;
  }
}

template <class B>
template <class U>
void ViewColumns<B>::Add(double scale, const double* v, U* u) const {
  const Index n = shape_.PlaneSize();
  for (int c = 0; c < ImageShape::kChannels; ++c) {
    static_assert(AddColumns<typename B::Scalar, U>::kMost == splat::kPoseTangent + 2 + splat::kLensTangent);
    AddColumns<typename B::Scalar, U> add{.scale = scale,
                                          .columns = num_images(),
                                          .stride = shape_.NumValues(),
                                          .first = images_.data() + c * n,
                                          .sum = u + c * n,
                                          .factors = {}};
    for (int k = 0; k < num_images(); ++k) add.factors[k] = v[Place(k, c)];
    ForEach<typename B::Space>(n, kImageGrain, add);
  }
}

template <class B>
ViewColumns<B> ColumnsOf(const FreeUnknowns& free, const AffineColor& color, const TargetView<B>& target,
                         typename B::ConstVectorView rendered, typename B::ConstVectorView moves) {
  B backend;
  ViewColumns<B> columns(free, target.shape());
  const Index values = target.shape().NumValues();
  const int pose = free.pose_tangent(), first_of_lens = pose + (free.color ? 2 : 0);
  for (int move = 0; move < free.num_moves(); ++move) {
    const typename B::VectorView image = columns.image(move < pose ? move : first_of_lens + move - pose);
    backend.Copy(moves.subspan(move * values, values), image);
    ScaleChannels<B>(ChannelsOf<typename B::Scalar>(color.gain), image);
  }
  if (free.color) {
    backend.Copy(rendered, columns.image(pose));
    backend.Fill(1, columns.image(pose + 1));
  }
  for (int k = 0; k < columns.num_images(); ++k) ClearMasked<B>(target.mask, columns.image(k));
  return columns;
}

template <class B>
typename B::Vector CameraDerivativeImages(const FreeUnknowns& free, const typename SplatBackend<B>::SplatView& view,
                                          const splat::Model<typename B::Scalar>& model,
                                          typename SplatBackend<B>::Workspace& workspace) {
  const Index values = ImageShape::kChannels * view.num_pixels();
  const int pose = free.pose_tangent();
  typename B::Vector moves;
  moves.ResizeForOverwrite(free.num_moves() * values);
  for (int k = 0; k < pose; ++k) {
    splat::PoseTangent unit;
    unit.v[k] = 1;
    ApplyPoseJ(view, model, unit, moves.data() + k * values, workspace);
  }
  for (int k = 0; k < free.lens_tangent(); ++k) {
    splat::LensTangent unit;
    unit.v[k] = 1;
    ApplyLensJ(view, unit, moves.data() + (pose + k) * values, workspace);
  }
  return moves;
}

template <class B>
std::vector<double> WeightedGram(const ViewColumns<B>& J, typename SplatBackend<B>::Loss& loss,
                                 const typename SplatBackend<B>::Loss::Linearization& W, ViewColumns<B>* weighted) {
  const auto n = static_cast<std::size_t>(J.free().num_tangent());
  const Index plane = J.shape().PlaneSize();
  std::vector<double> H(n * n);
  const auto at = [&](int row, int col) -> double& { return H[static_cast<std::size_t>(row) * n + std::size_t(col)]; };
  typename B::Vector one;
  if (weighted) {
    *weighted = ViewColumns<B>(J.free(), J.shape());
  } else {
    one.ResizeForOverwrite(J.shape().NumValues());
  }
  const int images = J.num_images();
  ImageProducts<B> products(ImageShape::kChannels * images * (images + 1) / 2);
  for (int k = 0; k < images; ++k) {
    const typename B::VectorView WJ = weighted ? weighted->image(k) : one.view();
    loss.ApplyW(W, J.image(k), WJ);
    for (int l = 0; l <= k; ++l) {
      for (int c = 0; c < ImageShape::kChannels; ++c) {
        products.AddDot(J.image(l).subspan(c * plane, plane),
                        typename B::ConstVectorView(WJ.subspan(c * plane, plane)));
      }
    }
  }
  const std::vector<double> sums = products.Read();
  auto product = sums.begin();
  for (int k = 0; k < images; ++k) {
    for (int l = 0; l <= k; ++l) {
      for (int c = 0; c < ImageShape::kChannels; ++c, ++product) {
        at(J.Place(k, c), J.Place(l, c)) += *product;
        if (l != k) at(J.Place(l, c), J.Place(k, c)) += *product;
      }
    }
  }
  return H;
}

template <class B>
std::vector<double> ViewCurvature(const FreeUnknowns& free, const std::array<double, 3>& background,
                                  const splat::Model<float>& model, const TargetView<B>& target) {
  typename SplatBackend<B>::Workspace workspace;
  typename SplatBackend<B>::SplatView view;
  view.Build(model, target.camera, background.data(), workspace);
  typename B::Vector image, image_gradient;
  image.ResizeForOverwrite(target.shape().NumValues());
  view.Render(image.data());
  const ViewColumns<B> columns =
      ColumnsOf<B>(free, {}, target, image.view(), CameraDerivativeImages<B>(free, view, model, workspace).view());
  // J is zero at masked pixels, so W needs no mask.
  typename SplatBackend<B>::Loss loss;
  typename SplatBackend<B>::Loss::Linearization W;
  image_gradient.ResizeForOverwrite(image.size());
  LinearizeLoss(loss, target, image.view(), image_gradient.view(), W);
  return WeightedGram(columns, loss, W);
}

}  // namespace vesta::gs
