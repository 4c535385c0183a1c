#include "bench/cameras/methods.h"

#include "kernels/core/check.h"

namespace vesta::bench {
namespace {

gs::CameraChoice WhatIsOff(const Perturbation& by) {
  if (by.focal != 0) return gs::CameraChoice::kAll;
  return by.exposure != 0 ? gs::CameraChoice::kPoseAndExposure : gs::CameraChoice::kPose;
}

// adam:ROTATION:TRANSLATION.
void ReadRates(const std::string& training, gs::CameraOptions* cameras) {
  const std::size_t begin = training.find(':') + 1, colon = training.find(':', begin);
  if (colon == std::string::npos) throw Error(training + ": the form is adam:ROTATION:TRANSLATION");
  cameras->adam_rotation = std::stod(training.substr(begin, colon - begin));
  cameras->adam_translation = std::stod(training.substr(colon + 1));
}

}  // namespace

Method MethodOf(const std::string& name, const Perturbation& by, const gs::CameraOptions& cameras) {
  Method method{.name = name, .training = name, .cameras = cameras};
  method.ending = TakeEnding(&method.training);
  const std::string& training = method.training;
  gs::CameraChoice& refine = method.cameras.refine;
  if (training == "exact" || training == "none" || training == "late") {
    refine = gs::CameraChoice::kNone;
  } else if (training == "gauss_newton" || training == "settled") {
    refine = WhatIsOff(by);
  } else if (training == "auto") {
    refine = gs::CameraChoice::kAuto;
  } else if (training.starts_with("adam:")) {
    refine = WhatIsOff(by), method.cameras.rule = gs::CameraRule::kAdam;
    ReadRates(training, &method.cameras);
  } else {
    throw Error(training +
                ": methods are exact, settled, none, late, gauss_newton, auto and adam:ROTATION:TRANSLATION");
  }
  const bool finds_no_cameras = method.ending == Ending::kLm || method.ending == Ending::kNothing;
  if (method.perturbs_late() && method.ending == Ending::kLm) {
    throw Error("late: what follows begins where the training has ended; choose another ending than lm");
  }
  if (refine == gs::CameraChoice::kAuto && !finds_no_cameras) {
    throw Error(name + ": what follows auto has nothing to go by; choose gauss_newton");
  }
  // The joint ones look for what is off where the training does not say what is looked for, the others for poses.
  const bool finds_all = method.ending == Ending::kJoint || method.ending == Ending::kReduced;
  method.ending_finds = method.cameras.refines() ? refine : finds_all ? WhatIsOff(by) : gs::CameraChoice::kPose;
  return method;
}

}  // namespace vesta::bench
