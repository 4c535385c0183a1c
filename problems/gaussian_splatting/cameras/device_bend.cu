// What of finding cameras nvcc compiles.
#include "kernels/core/for_each.cuh"
#include "problems/gaussian_splatting/cameras/bend_derivative.h"

namespace vesta {

VESTA_DEVICE_FOR_EACH(gs::BendDerivative<float>, "derivative by a bend")

}  // namespace vesta
