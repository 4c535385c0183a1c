// Options of taking Gaussians out in the course of the Adam stage.
#pragma once

#include "kernels/core/schema.h"

namespace vesta::gs {

// Times are parts of the Adam stage.
struct ParsimonyOptions {
  // What hardly any training view shows (Support::is_wanting) goes at `begin`, unless that is the start, and at `end`.
  bool supported = true;
  // What each parameter of a Gaussian must be worth (WorthTheirPrice, prune.h), and each coefficient of its harmonics
  // above the constant, which go at `begin` (DegreesWorthTheirPrice, harmonics.h); 0: nothing.
  double price = 1;
  double sh_price = 0.5;
  double keep = 1;  // below 1, in place of a price: part of the Gaussians there are at `begin` that is left at `end`
  double begin = 0.6;
  double end = 0.8;
  double every = 0.025;

  bool prunes_to_count() const { return keep < 1; }
  bool prunes() const { return prunes_to_count() || price > 0; }
  // Whether views judge Gaussians while Adam holds what it works with.
  bool judges() const { return prunes() || sh_price > 0; }
  // Options by which the model stays as it is.
  static ParsimonyOptions None() {
    ParsimonyOptions none;
    none.supported = false, none.price = none.sh_price = 0;
    return none;
  }
};

const schema::Table<ParsimonyOptions>& ParsimonyFields();

// Throws Error, one line, where what is asked for cannot be done.
void CheckTogether(const ParsimonyOptions& parsimony);

}  // namespace vesta::gs
