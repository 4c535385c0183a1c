#include "splatting/io/scenes/test_views.h"

#include <algorithm>
#include <string_view>

#include "kernels/core/check.h"
#include "kernels/core/text_file.h"

namespace vesta::gs {
namespace {

void ChooseListed(const std::string& path, std::vector<View>* views) {
  const std::string text = ReadFile(path);
  for (View& view : *views) view.role = ViewRole::kTraining;
  std::string_view rest = text, line;
  for (Index number = 1; NextLine(&rest, &line); ++number) {
    const std::string_view name = Trimmed(line);
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
