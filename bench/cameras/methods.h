// The ways of finding cameras that are compared, by their names.
#pragma once

#include <string>

#include "bench/cameras/endings.h"
#include "bench/cameras/perturbed_scene.h"
#include "problems/gaussian_splatting/cameras/options.h"

namespace vesta::bench {

struct Method {
  std::string name;      // with what follows the Adam stage
  std::string training;  // without
  Ending ending = Ending::kLm;
  // Of these the rule, its rates and what is looked for are the method's.
  gs::CameraOptions cameras;
  gs::CameraChoice ending_finds = gs::CameraChoice::kNone;

  // Whether it begins from the cameras of the scene.
  bool is_unperturbed() const { return training == "exact" || settles(); }
  // Whether it tells where a training takes right cameras.
  bool settles() const { return training == "settled"; }
  // Whether the Adam stage is on right cameras and what follows on others.
  bool perturbs_late() const { return training == "late"; }
};

// Throws Error for a name that is none, and where its parts do not go together.
Method MethodOf(const std::string& name, const Perturbation& by, const gs::CameraOptions& cameras);

}  // namespace vesta::bench
