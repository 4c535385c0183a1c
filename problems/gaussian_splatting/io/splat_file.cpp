#include "problems/gaussian_splatting/io/splat_file.h"

#include <algorithm>
#include <filesystem>
#include <string_view>

#include "kernels/core/check.h"
#include "kernels/core/text_file.h"
#include "problems/gaussian_splatting/io/ply.h"
#include "problems/gaussian_splatting/io/spz.h"

namespace vesta::gs {
namespace {

using Writer = void (*)(const std::string& path, const SplatModel& model);

// The first that fits counts.
constexpr struct {
  std::string_view extension;
  Writer write;
} kFormats[] = {{".ply", WriteSplatPly}, {".spz", WriteSpz}};

Writer WriterFor(const std::string& path) {
  std::string name = std::filesystem::path(path).filename().string();
  const auto lower = [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c + ('a' - 'A')) : c; };
  std::transform(name.begin(), name.end(), name.begin(), lower);
  for (const auto& format : kFormats) {
    if (name.ends_with(format.extension)) return format.write;
  }
  Fail("{}: the extension says the format: .ply, .compressed.ply or .spz", path);
}

}  // namespace

SplatModel ReadSplat(const std::string& path, const ReadSplatOptions& options) {
  std::string bytes = ReadFile(path);
  if (bytes.starts_with("\x1f\x8b")) return ReadSpz(path, bytes, options);
  return ReadSplatPly(path, options);
}

void WriteSplat(const std::string& path, const SplatModel& model) { WriterFor(path)(path, model); }

void CheckSplatExtension(const std::string& path) { WriterFor(path); }

}  // namespace vesta::gs
