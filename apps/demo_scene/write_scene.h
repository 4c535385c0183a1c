// The demo scene as files, in COLMAP's layout.
#pragma once

#include <cstdint>
#include <string>

namespace vesta::demo {

struct DemoOptions {
  int views = 40;                 // 2..9999
  int width = 200, height = 150;  // pixels, 8..4096
  int points = 3000;              // 1..1000000
  std::uint64_t seed = 0;
};

// Takes the pictures and writes FOLDER/images/view_NNNN.png and the binary model FOLDER/sparse/0. Throws Error when an
// option is out of range or the folder cannot be written.
void WriteDemoScene(const DemoOptions& options, const std::string& folder);

}  // namespace vesta::demo
