// The photographs of a scene: in its views, or where they do not fit in a store that decodes them when they are needed.
#pragma once

#include "splatting/io/scenes/view_photograph.h"

namespace vesta::gs {

// Decodes them in parallel: cameras follow their images, and what cannot be used is refused. Up to budget_bytes all
// stay in their views; else Scene::photographs reads them again from their files, which must stay, and keeps as many as
// fit. Once the budget is full, only headers are read, since decoding thousands takes many minutes: what only decoding
// tells, as a file that is cut short, is then refused when its turn comes. Throws Error where not even two fit, and
// what ReadPhotograph and ForeseePhotograph throw.
void LoadPhotographs(const PhotographRule& rule, double budget_bytes, Scene* scene);

}  // namespace vesta::gs
