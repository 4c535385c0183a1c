// Gaussians that cannot be drawn: with a value that is not finite, or a quaternion of zero.
#pragma once

#include <string>

#include "problems/gaussian_splatting/model/splat_model.h"

namespace vesta::gs {

struct ReadSplatOptions {
  // A Gaussian with a value that is not finite, or with a zero quaternion, cannot be drawn. By default a file with such
  // is refused; with this set they are left out, the others keep their order.
  bool drop_unusable = false;
};

// Of a model as a file has it, does what the options say. Throws Error, one line with the file, where there are such
// Gaussians that may not be left out, or none is left.
void TakeUsableGaussians(const std::string& path, const ReadSplatOptions& options, SplatModel* model);

// Of a model to be written to the file. Throws Error where there are such Gaussians, or another number of values than
// the degree and count say.
void CheckDrawable(const std::string& path, const SplatModel& model);

}  // namespace vesta::gs
