#include "problems/gaussian_splatting/cameras/view_columns.h"

#include <algorithm>

#include "kernels/gaussian_splatting/lens_jacobian.h"
#include "kernels/gaussian_splatting/pose_jacobian.h"
#include "problems/gaussian_splatting/cameras/view_columns.inl"

namespace vesta::gs {

template <class B>
template <class U>
void ViewColumns<B>::Project(const U* u, double* g) const {
  const Index n = shape_.PlaneSize();
  std::fill_n(g, free_.num_tangent(), 0.0);
  for (int k = 0; k < num_images(); ++k) {
    for (int c = 0; c < ImageShape::kChannels; ++c) g[Place(k, c)] += Dot(image(k).data() + c * n, u + c * n, n);
  }
}

template <class B>
template <class U>
void ViewColumns<B>::Add(double scale, const double* v, U* u) const {
  const Index n = shape_.PlaneSize();
  for (int c = 0; c < ImageShape::kChannels; ++c) {
    ParallelFor(n, kImageGrain, [&](Index i) {
      double sum = 0;
      for (int k = 0; k < num_images(); ++k) sum += v[Place(k, c)] * static_cast<double>(image(k)[c * n + i]);
      u[c * n + i] += static_cast<U>(scale * sum);
    });
  }
}

using Float = CpuBackend<float>;
using Double = CpuBackend<double>;
template class ViewColumns<Float>;
template class ViewColumns<Double>;
template void ViewColumns<Float>::Project(const float*, double*) const;
template void ViewColumns<Float>::Project(const double*, double*) const;
template void ViewColumns<Double>::Project(const double*, double*) const;
template void ViewColumns<Float>::Add(double, const double*, float*) const;
template void ViewColumns<Float>::Add(double, const double*, double*) const;
template void ViewColumns<Double>::Add(double, const double*, double*) const;
template ViewColumns<Float> ColumnsOf(const FreeUnknowns&, const AffineColor&, const TargetView<Float>&,
                                      HostSpan<const float>, HostSpan<const float>);
template ViewColumns<Double> ColumnsOf(const FreeUnknowns&, const AffineColor&, const TargetView<Double>&,
                                       HostSpan<const double>, HostSpan<const double>);
template HostBuffer<float> MovesOf<Float>(const FreeUnknowns&, const TargetView<Float>&, const splat::SplatView<float>&,
                                          const splat::Model<float>&, HostSpan<const float>,
                                          splat::ViewWorkspace<float>&);
template HostBuffer<double> MovesOf<Double>(const FreeUnknowns&, const TargetView<Double>&,
                                            const splat::SplatView<double>&, const splat::Model<double>&,
                                            HostSpan<const double>, splat::ViewWorkspace<double>&);
template std::vector<double> WeightedGram(const ViewColumns<Float>&, PhotometricLoss<float>&,
                                          const PhotometricLoss<float>::Linearization&, ViewColumns<Float>*);
template std::vector<double> WeightedGram(const ViewColumns<Double>&, PhotometricLoss<double>&,
                                          const PhotometricLoss<double>::Linearization&, ViewColumns<Double>*);

}  // namespace vesta::gs
