// SPDX-License-Identifier: Apache-2.0
#include "splatting/cameras/derivatives/view_columns.h"

#include "kernels/gaussian_splatting/view/camera_jacobian.h"
#include "splatting/cameras/derivatives/view_columns.inl"

namespace vesta::gs {

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
template HostBuffer<float> CameraDerivativeImages<Float>(const FreeUnknowns&, const splat::SplatView<float>&,
                                                         const splat::Model<float>&, splat::ViewWorkspace<float>&);
template HostBuffer<double> CameraDerivativeImages<Double>(const FreeUnknowns&, const splat::SplatView<double>&,
                                                           const splat::Model<double>&, splat::ViewWorkspace<double>&);
template std::vector<double> WeightedGram(const ViewColumns<Float>&, PhotometricLoss<float>&,
                                          const PhotometricLoss<float>::Linearization&, ViewColumns<Float>*);
template std::vector<double> WeightedGram(const ViewColumns<Double>&, PhotometricLoss<double>&,
                                          const PhotometricLoss<double>::Linearization&, ViewColumns<Double>*);

template std::vector<double> ViewCurvature(const FreeUnknowns&, const std::array<double, 3>&,
                                           const splat::Model<float>&, const TargetView<CpuBackend<float>>&);

}  // namespace vesta::gs
