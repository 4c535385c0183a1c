// What a training has to say to its user.
#pragma once

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

namespace vesta::gs {

// Lines on what is done otherwise than asked for; each once, though a training that goes on says it again.
class TrainingNotes {
 public:
  void Add(std::string line) {
    if (std::ranges::find(lines_, line) == lines_.end()) lines_.push_back(std::move(line));
  }
  const std::vector<std::string>& lines() const { return lines_; }
  // Those of before a break.
  void Restore(std::vector<std::string> lines) { lines_ = std::move(lines); }
  std::vector<std::string> Take() { return std::move(lines_); }

 private:
  std::vector<std::string> lines_;
};

}  // namespace vesta::gs
