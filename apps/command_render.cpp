// render: a splat's images of the test views.
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <set>

#include "apps/commands.h"
#include "apps/output_folder.h"
#include "apps/posed_model.h"
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

// One for each view, all different as far as the views' names are.
std::vector<std::string> FileNames(const std::vector<const gs::View*>& views) {
  for (const bool with_extension : {false, true}) {
    std::vector<std::string> names;
    names.reserve(views.size());
    for (const gs::View* view : views) names.push_back(FileName(*view, with_extension));
    if (with_extension || std::set<std::string>(names.begin(), names.end()).size() == names.size()) return names;
  }
  return {};
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
  OutputFolder out(flags.out);
  const PosedModel posed = LoadPosedModel(line);
  std::vector<const gs::View*> views;
  for (const gs::View& view : posed.scene.views) {
    if (view.is_test) views.push_back(&view);
  }
  const std::vector<std::string> names = FileNames(views);
  gs::Renderer renderer(ToDouble(posed.model.background), gs::NearPlane(posed.scene));
  for (std::size_t i = 0; i < views.size(); ++i) {
    const gs::Image image = renderer.Render(posed.model, *views[i]);
    gs::SavePng(out.File(names[i]), flags.truth ? SideBySide(image, views[i]->image) : image);
    out.Keep();
  }
  fmt::print("wrote {} images to {}\n", views.size(), flags.out);
  return 0;
}

}  // namespace vesta::app
