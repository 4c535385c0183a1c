#include "problems/gaussian_splatting/parsimony/options.h"

namespace vesta::gs {

const schema::Table<ParsimonyOptions>& ParsimonyFields() {
  using O = ParsimonyOptions;
  constexpr schema::Range kPart{0, 1};
  static const schema::Table<O> fields = {
      {"supported", &O::supported, "whether what hardly any training view shows is taken out"},
      {"keep",
       &O::keep,
       {1e-9, 1},
       "part of the Gaussians that stays, once they have become as many as they will",
       "keep"},
      {"criterion", &O::criterion, kCriteria, "who goes first; worth: whoever the training views miss least"},
      {"begin", &O::begin, kPart, "part of the Adam stage after which the others begin to go"},
      {"end", &O::end, kPart, "part of it after which all of them are gone"},
      {"every", &O::every, {1e-6, 1}, "part of it between two times"},
  };
  return fields;
}

}  // namespace vesta::gs
