// Options of taking Gaussians out in the course of the Adam stage.
#pragma once

#include "kernels/core/schema.h"
#include "problems/gaussian_splatting/parsimony/criterion.h"

namespace vesta::gs {

// Times are parts of the Adam stage.
struct ParsimonyOptions {
  // What hardly any training view shows (Support::is_wanting) goes at `begin` and at `end`.
  bool supported = true;
  double keep = 1;  // part of the Gaussians there are at `begin` that is left at `end`; 1: none need go
  Criterion criterion = Criterion::kWorth;
  double begin = 0.6;
  double end = 0.8;
  double every = 0.025;

  bool prunes() const { return keep < 1; }
};

const schema::Table<ParsimonyOptions>& ParsimonyFields();

}  // namespace vesta::gs
