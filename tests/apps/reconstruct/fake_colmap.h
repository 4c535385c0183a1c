// SPDX-License-Identifier: Apache-2.0
// A script in place of COLMAP, which records its arguments and copies prepared models.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "tests/apps/run_program.h"
#include "tests/apps/search_path.h"
#include "tests/apps/tiny_scene.h"

namespace vesta::test {

struct ColmapCall {
  std::string command;
  std::map<std::string, std::string> options;  // without dashes
  std::string names;                           // content of the file of image_list_path
};

class FakeColmap {
 public:
  // Puts the script first in PATH. Its version of the options: SiftExtraction and SiftMatching, as in 3.8, or
  // FeatureExtraction and FeatureMatching, as in 4.
  explicit FakeColmap(const std::string& folder, bool is_new = false);

  // The mapper writes models/NUMBER with the first `images` images of the tiny scene.
  void AddModel(int number, std::size_t images) const;
  // Runs these shell commands when COLMAP is called with this command. "exit 3" fails.
  void When(const std::string& command, const std::string& commands) const;
  // All calls, without those for help. Forgets them.
  std::vector<ColmapCall> TakeCalls() const;
  // The same, only the commands.
  std::vector<std::string> TakeCommands() const;

  std::string programs() const { return folder_ + "/bin"; }

 private:
  std::string folder_;
  PathIs path_;
};

}  // namespace vesta::test
