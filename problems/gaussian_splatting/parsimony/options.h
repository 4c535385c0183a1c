// Options of taking Gaussians out in the course of the Adam stage.
#pragma once

#include "kernels/core/schema.h"
#include "problems/gaussian_splatting/parsimony/criterion.h"

namespace vesta::gs {

// Times are parts of the Adam stage.
struct ParsimonyOptions {
  // What hardly any training view shows (Support::is_wanting) goes at `begin`, unless that is the start, and at `end`.
  bool supported = true;
  double keep = 1;  // part of the Gaussians there are at `begin` that is left at `end`; 1: none need go
  Criterion criterion = Criterion::kWorth;
  double begin = 0.6;
  double end = 0.8;
  double every = 0.025;

  bool prunes() const { return keep < 1; }
};

const schema::Table<ParsimonyOptions>& ParsimonyFields();

// Throws Error, one line, where what is asked for cannot be done.
void CheckTogether(const ParsimonyOptions& parsimony);

}  // namespace vesta::gs
