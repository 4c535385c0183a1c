#include "problems/gaussian_splatting/io/test_views.h"

#include <algorithm>
#include <string_view>

#include "kernels/core/check.h"
#include "kernels/core/text_file.h"

namespace vesta::gs {
namespace {

std::string_view Trimmed(std::string_view line) {
  constexpr const char* kSpace = " \t\r";
  const std::size_t begin = std::min(line.find_first_not_of(kSpace), line.size());
  return line.substr(begin, line.find_last_not_of(kSpace) + 1 - begin);
}

void ChooseListed(const std::string& path, std::vector<View>* views) {
  const std::string text = ReadFile(path);
  for (View& view : *views) view.role = ViewRole::kTraining;
  std::string_view rest = text;
  for (Index number = 1; !rest.empty(); ++number) {
    const std::size_t end = std::min(rest.find('\n'), rest.size());
    const std::string_view name = Trimmed(rest.substr(0, end));
    rest.remove_prefix(std::min(end + 1, rest.size()));
    if (name.empty() || name.front() == '#') continue;
    const auto view = std::find_if(views->begin(), views->end(), [&](const View& v) { return v.name == name; });
    if (view == views->end()) {
      Fail("{}: line {}: the scene has no photograph {}; write names as its model does, {} for one", path, number,
           Printable(name), Printable(views->front().name));
    }
    view->role = ViewRole::kTest;
  }
}

}  // namespace

void ChooseTestViews(const TestViews& choice, std::vector<View>* views) {
  if (choice.every && !choice.list.empty()) Fail("--test_every and --test_list: give only one of them");
  if (choice.every) SplitByCount(*choice.every, views);
  if (!choice.list.empty()) ChooseListed(choice.list, views);
}

}  // namespace vesta::gs
