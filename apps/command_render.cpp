// render: a splat's images of the test views.
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <set>

#include "apps/commands.h"
#include "apps/outputs.h"
#include "apps/posed_model.h"
#include "apps/print.h"
#include "problems/gaussian_splatting/evaluate/metrics.h"
#include "problems/gaussian_splatting/io/image.h"

namespace vesta::app {
namespace {

// A view's name as that of a file: folders become part of the name, with_extension keeps ".jpg" before ".png".
std::string FileName(const gs::View& view, bool with_extension) {
  std::string name = view.name;
  if (!with_extension) name = std::filesystem::path(name).replace_extension().string();
  std::replace(name.begin(), name.end(), '/', '_');
  return name + ".png";
}

// One for each view, all different: with extensions where names are the same without, and numbered where with them too
// ("a/b.jpg" beside "a_b.jpg").
std::vector<std::string> FileNames(const std::vector<const gs::View*>& views) {
  std::vector<std::string> names;
  std::set<std::string> taken;
  for (const bool with_extension : {false, true}) {
    names.clear();
    for (const gs::View* view : views) names.push_back(FileName(*view, with_extension));
    taken = {names.begin(), names.end()};
    if (taken.size() == names.size()) return names;
  }
  std::set<std::string> seen;
  for (std::string& name : names) {
    const std::string stem = name.substr(0, name.rfind('.'));
    for (int number = 2; !seen.insert(name).second; ++number) {
      std::string numbered = fmt::format("{}_{}.png", stem, number);
      if (taken.insert(numbered).second) name = std::move(numbered);
    }
  }
  return names;
}

// Both of the same size.
gs::Image SideBySide(const gs::Image& left, const gs::Image& right) {
  gs::Image both(2 * left.width, left.height);
  for (int channel = 0; channel < 3; ++channel) {
    float* out = both.plane(channel);
    for (int y = 0; y < left.height; ++y) {
      for (const gs::Image* half : {&left, &right}) {
        out = std::copy_n(half->plane(channel) + static_cast<std::ptrdiff_t>(y) * half->width, half->width, out);
      }
    }
  }
  return both;
}

}  // namespace

int RunRender(const CommandLine& line) {
  const Flags& flags = line.flags;
  const std::string given = Given("out", flags.out);
  RunFiles files = FilesOf(line);
  files.WritesInto(given, flags.out);
  files.Check();
  OutputFolder out(flags.out);
  const PosedModel posed = LoadPosedModel(line);
  files.ReadsScene(line.arguments[1], posed.scene);
  std::vector<const gs::View*> views;
  for (const gs::View& view : posed.scene.views) {
    if (view.is_test()) views.push_back(&view);
  }
  const std::vector<std::string> names = FileNames(views);
  for (const std::string& name : names) files.Writes(given, out.File(name));
  files.Check();
  gs::Renderer renderer(ToDouble(posed.model.background), gs::NearPlane(posed.scene));
  for (std::size_t i = 0; i < views.size(); ++i) {
    const gs::Image image = renderer.Render(posed.model, *views[i]);
    gs::SavePng(out.File(names[i]), flags.truth ? SideBySide(image, *views[i]->Photograph()) : image);
    out.Keep();
  }
  Print("wrote {} images to {}\n", views.size(), flags.out);
  return 0;
}

}  // namespace vesta::app
