// The photographs of a scene: in its views, or where they do not fit in a store that decodes them when they are needed.
#pragma once

#include "problems/gaussian_splatting/io/view_photograph.h"

namespace vesta::gs {

// Decodes each once, in parallel, whatever becomes of it: cameras follow their images, and what cannot be used is
// refused now, not in the middle of a training. Up to budget_bytes all stay in their views; else Scene::photographs
// reads them again from their files, which must stay, and keeps as many as fit. Throws Error where not even two fit,
// and what ReadPhotograph throws.
void LoadPhotographs(const PhotographRule& rule, double budget_bytes, Scene* scene);

}  // namespace vesta::gs
