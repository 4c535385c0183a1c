#include "problems/gaussian_splatting/cameras/view_columns.h"

#include <algorithm>

#include "kernels/gaussian_splatting/pose_jacobian.h"
#include "problems/gaussian_splatting/cameras/image_products.h"
#include "problems/gaussian_splatting/model/masked_loss.h"

namespace vesta::gs {

template <class S>
int ViewColumns<S>::Place(int k, int channel) const {
  const int pose = free_.pose_tangent();
  if (k < pose) return k;
  if (!free_.color) return free_.Lens(k - pose);
  return k == pose ? free_.Gain(channel) : k == pose + 1 ? free_.Offset(channel) : free_.Lens(k - pose - 2);
}

template <class S>
template <class U>
void ViewColumns<S>::Project(const U* u, double* g) const {
  const Index n = shape_.PlaneSize();
  std::fill_n(g, free_.num_tangent(), 0.0);
  for (int k = 0; k < num_images(); ++k) {
    for (int c = 0; c < ImageShape::kChannels; ++c) g[Place(k, c)] += Dot(image(k).data() + c * n, u + c * n, n);
  }
}

template <class S>
template <class U>
void ViewColumns<S>::Add(double scale, const double* v, U* u) const {
  const Index n = shape_.PlaneSize();
  for (int c = 0; c < ImageShape::kChannels; ++c) {
    ParallelFor(n, kImageGrain, [&](Index i) {
      double sum = 0;
      for (int k = 0; k < num_images(); ++k) sum += v[Place(k, c)] * static_cast<double>(image(k)[c * n + i]);
      u[c * n + i] += static_cast<U>(scale * sum);
    });
  }
}

template <class S>
ViewColumns<S> ColumnsOf(const FreeUnknowns& free, const AffineColor& color, const TargetView<CpuBackend<S>>& target,
                         HostSpan<const S> rendered, HostSpan<const S> moves) {
  ViewColumns<S> columns(free, target.shape());
  const Index values = target.shape().NumValues();
  const int pose = free.pose_tangent(), first_of_lens = pose + (free.color ? 2 : 0);
  AffineColor gain = color;
  gain.offset = {};
  for (int move = 0; move < pose + free.lens_tangent(); ++move) {
    const HostSpan<S> image = columns.image(move < pose ? move : first_of_lens + move - pose);
    std::copy_n(moves.data() + move * values, values, image.data());
    gain.Apply(image);
  }
  if (free.color) {
    std::copy_n(rendered.data(), values, columns.image(pose).data());
    std::fill_n(columns.image(pose + 1).data(), values, S(1));
  }
  for (int k = 0; k < columns.num_images(); ++k) ClearLeftOut<CpuBackend<S>>(target.mask, columns.image(k));
  return columns;
}

template <class S>
HostBuffer<S> MovesOf(const FreeUnknowns& free, const splat::SplatView<S>& view, const splat::Model<S>& model,
                      splat::ViewWorkspace<S>& workspace) {
  const Index values = ImageShape::kChannels * view.num_pixels();
  const int pose = free.pose_tangent();
  HostBuffer<S> moves;
  moves.ResizeForOverwrite((pose + free.lens_tangent()) * values);
  for (int k = 0; k < pose; ++k) {
    splat::PoseTangent unit;
    unit.v[k] = 1;
    splat::ApplyPoseJ(view, model, unit, moves.data() + k * values, workspace);
  }
  for (int k = 0; k < free.lens_tangent(); ++k) {
    splat::LensTangent unit;
    unit.v[k] = 1;
    splat::ApplyLensJ(view, unit, moves.data() + (pose + k) * values, workspace);
  }
  return moves;
}

template <class S>
std::vector<double> WeightedGram(const ViewColumns<S>& J, PhotometricLoss<S>& loss,
                                 const typename PhotometricLoss<S>::Linearization& W, ViewColumns<S>* weighted) {
  const auto n = static_cast<std::size_t>(J.free().num_tangent());
  const Index plane = J.shape().PlaneSize();
  std::vector<double> H(n * n);
  const auto at = [&](int row, int col) -> double& { return H[static_cast<std::size_t>(row) * n + std::size_t(col)]; };
  HostBuffer<S> one;
  if (weighted) {
    *weighted = ViewColumns<S>(J.free(), J.shape());
  } else {
    one.ResizeForOverwrite(J.shape().NumValues());
  }
  for (int k = 0; k < J.num_images(); ++k) {
    const HostSpan<S> WJ = weighted ? weighted->image(k) : one.view();
    loss.ApplyW(W, J.image(k), WJ);
    for (int l = 0; l <= k; ++l) {
      for (int c = 0; c < ImageShape::kChannels; ++c) {
        const double product = Dot(J.image(l).data() + c * plane, WJ.data() + c * plane, plane);
        at(J.Place(k, c), J.Place(l, c)) += product;
        if (l != k) at(J.Place(l, c), J.Place(k, c)) += product;
      }
    }
  }
  return H;
}

template class ViewColumns<float>;
template class ViewColumns<double>;
template void ViewColumns<float>::Project(const float*, double*) const;
template void ViewColumns<float>::Project(const double*, double*) const;
template void ViewColumns<double>::Project(const double*, double*) const;
template void ViewColumns<float>::Add(double, const double*, float*) const;
template void ViewColumns<float>::Add(double, const double*, double*) const;
template void ViewColumns<double>::Add(double, const double*, double*) const;
template ViewColumns<float> ColumnsOf(const FreeUnknowns&, const AffineColor&, const TargetView<CpuBackend<float>>&,
                                      HostSpan<const float>, HostSpan<const float>);
template ViewColumns<double> ColumnsOf(const FreeUnknowns&, const AffineColor&, const TargetView<CpuBackend<double>>&,
                                       HostSpan<const double>, HostSpan<const double>);
template HostBuffer<float> MovesOf(const FreeUnknowns&, const splat::SplatView<float>&, const splat::Model<float>&,
                                   splat::ViewWorkspace<float>&);
template HostBuffer<double> MovesOf(const FreeUnknowns&, const splat::SplatView<double>&, const splat::Model<double>&,
                                    splat::ViewWorkspace<double>&);
template std::vector<double> WeightedGram(const ViewColumns<float>&, PhotometricLoss<float>&,
                                          const PhotometricLoss<float>::Linearization&, ViewColumns<float>*);
template std::vector<double> WeightedGram(const ViewColumns<double>&, PhotometricLoss<double>&,
                                          const PhotometricLoss<double>::Linearization&, ViewColumns<double>*);

}  // namespace vesta::gs
