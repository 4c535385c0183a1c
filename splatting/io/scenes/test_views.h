// Which views of a scene are for testing, where the user says so.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "problems/gaussian_splatting/scene/scene.h"

namespace vesta::gs {

// At most one of the two; neither leaves what the scene's reader has chosen.
struct TestViews {
  std::optional<int> every;  // each of so many by name, the first among them; 0: none
  std::string list;          // a file with a name in each line, as the model has it; empty lines and # are passed over
};

// Sets the roles of the views, which are sorted by name. Throws Error, one line with the file and the line, for a name
// that no view has.
void ChooseTestViews(const TestViews& choice, std::vector<View>* views);

}  // namespace vesta::gs
