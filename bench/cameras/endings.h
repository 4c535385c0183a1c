// What may follow a training's Adam stage where cameras are not where they are said to be.
#pragma once

#include <string>
#include <vector>

#include "problems/gaussian_splatting/cameras/refine_jointly.h"

namespace vesta::bench {

enum class Ending {
  kLm,  // the training's own stage, on the splats
  kNothing,
  kAlign,      // each camera fitted to the splat, which stays (cameras/align_view.h)
  kAlternate,  // that, and LM on the splats with the cameras as they are, in turns
  kJoint,      // cameras and splats at once (cameras/refine_jointly.h)
  kReduced,    // the same with cameras eliminated
};

// From "METHOD+ENDING", which becomes "METHOD"; kLm where there is no plus. Throws Error for an unknown name.
Ending TakeEnding(std::string* method);

struct EndingOptions {
  gs::JointOptions joint;
  int rounds = 4;  // of kAlternate, which share joint.iterations
};

// Of kAlign, kAlternate, kJoint and kReduced.
struct Ended {
  gs::SplatModel model;
  std::vector<gs::ViewUnknowns> views;  // from as they were given
  double seconds = 0;                   // of this process on all its threads
  int products = 0;                     // with J^T W J of all views, of splats or of both
  std::string report;                   // the engine's
};
// start: of each view, from as it was given; empty: as given. kAlign and kAlternate find no exposures, and throw Error
// where those are free or the start has some.
Ended RunEnding(Ending ending, gs::SplatModel model, const std::vector<const gs::View*>& given,
                const std::vector<gs::ViewUnknowns>& start, const EndingOptions& options);

}  // namespace vesta::bench
