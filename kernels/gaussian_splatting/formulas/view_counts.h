// What of a view of a model decides how much memory its passes take.
#pragma once

namespace vesta::splat {

// Numbers that may be means over views.
struct ViewCounts {
  double pixels = 0, tiles = 0;
  double splats = 0;   // seen
  double pairs = 0;    // of splat and tile
  double entries = 0;  // of pixel and splat: those of a cached Jacobian
};

// What buffers that views share have to spare, so that the next view seldom needs more.
inline constexpr double kSpareRoom = 1.125;

}  // namespace vesta::splat
