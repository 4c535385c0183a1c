#include "apps/report/heat_color.h"

#include "problems/gaussian_splatting/scene/color_scale.h"

namespace vesta::app {
namespace {

// Of matplotlib's inferno, which the page's scale shows too.
constexpr std::array<std::array<float, 3>, 6> kColors = {{{0.000f, 0.000f, 0.016f},
                                                          {0.259f, 0.039f, 0.408f},
                                                          {0.576f, 0.149f, 0.404f},
                                                          {0.867f, 0.318f, 0.227f},
                                                          {0.988f, 0.647f, 0.039f},
                                                          {0.988f, 1.000f, 0.643f}}};

}  // namespace

std::array<float, 3> HeatColor(float of) { return gs::OnScale(kColors, of); }

}  // namespace vesta::app
