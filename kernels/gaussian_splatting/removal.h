// What the loss of a view would be without a splat, of each splat by itself.
//
// A pixel is affine in the alpha of each splat. So without the splat its colour changes by exactly
//   delta = -alpha d colour / d alpha = S alpha / (1 - alpha) - w c                (pixel_steps.h: w = alpha T)
// as long as no pixel closes later for it (the transmittance stop). What that does to the loss: loss_of_change.h.
#pragma once

namespace vesta::splat {

// Of one splat, summed over pixels and channels.
template <class S>
struct Removal {
  S rise;    // of the loss when the splat goes; negative where that is better without it
  S weight;  // of its shares of the pixels, alpha T: not by channels
};
inline constexpr int kRemovalSums = 2;

}  // namespace vesta::splat
