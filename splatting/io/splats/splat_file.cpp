#include "splatting/io/splats/splat_file.h"

#include <algorithm>
#include <filesystem>
#include <string_view>
#include <utility>

#include "kernels/core/check.h"
#include "kernels/core/text_file.h"
#include "splatting/io/splats/compressed_ply.h"
#include "splatting/io/splats/ply.h"
#include "splatting/io/splats/spz.h"

namespace vesta::gs {
namespace {

using Writer = void (*)(const std::string& path, const SplatModel& model);

// The first that fits counts.
constexpr struct {
  std::string_view extension;
  Writer write;
} kFormats[] = {{".compressed.ply", WriteCompressedPly}, {".ply", WriteSplatPly}, {".spz", WriteSpz}};

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
  if (bytes.starts_with("NGSP")) {
    Fail("{}: .spz of version 4 or later, where versions 1 to 3 are read; export it as one of those, or as .ply", path);
  }
  if (bytes.starts_with("\x1f\x8b")) return ReadSpz(path, bytes, options);
  const PlyFile file(path, std::move(bytes));
  return IsCompressedPly(file) ? ReadCompressedPly(file, options) : ReadSplatPly(file, options);
}

void WriteSplat(const std::string& path, const SplatModel& model) { WriterFor(path)(path, model); }

void CheckSplatExtension(const std::string& path) { WriterFor(path); }

}  // namespace vesta::gs
