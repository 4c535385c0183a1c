// SPDX-License-Identifier: Apache-2.0
#include "splatting/parsimony/parsimony_options.h"

#include "kernels/core/check.h"

namespace vesta::gs {

const schema::Table<ParsimonyOptions>& ParsimonyFields() {
  using O = ParsimonyOptions;
  // Behind the end nothing would make up for what goes.
  constexpr schema::Range kBeforeTheEnd{0, 0.99};
  static const schema::Table<O> fields = {
      {"supported", &O::supported, "whether what hardly any training view shows is taken out"},
      {"price",
       &O::price,
       {0, 1e9},
       "what each parameter of a Gaussian must be worth, in parts of the cost by the pixels' values (1: Akaike)"},
      {"sh_price", &O::sh_price, {0, 1e9}, "the same for those of the higher degrees of its harmonics"},
      {"keep",
       &O::keep,
       {1e-9, 1},
       "part of the Gaussians that stays; of a training, of as many as they will become",
       "keep"},
      {"begin", &O::begin, kBeforeTheEnd,
       "part of the Adam stage after which the others begin to go; not before density.end"},
      {"end", &O::end, kBeforeTheEnd, "part of it after which all of them are gone"},
      {"every", &O::every, {1e-6, 1}, "part of it between two times"},
  };
  return fields;
}

void CheckTogether(const ParsimonyOptions& parsimony) {
  if (!parsimony.prunes()) return;
  if (parsimony.begin > parsimony.end) {
    Fail(kBadArgument, "parsimony.begin={} lies behind parsimony.end={}: none would go", parsimony.begin,
         parsimony.end);
  }
}

}  // namespace vesta::gs
