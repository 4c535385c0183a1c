// Views' own unknowns on a GPU.
#include "kernels/gaussian_splatting/device_camera.h"
#include "problems/gaussian_splatting/cameras/view_columns.inl"
#include "problems/gaussian_splatting/cameras/view_curvature.inl"
#include "problems/gaussian_splatting/model/device_splat_backend.h"

namespace vesta::gs {

template std::vector<double> ViewCurvature(const FreeUnknowns&, const std::array<double, 3>&,
                                           const splat::Model<float>&, const TargetView<CudaBackend<float>>&);

}  // namespace vesta::gs
