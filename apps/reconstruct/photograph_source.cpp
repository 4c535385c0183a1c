// SPDX-License-Identifier: Apache-2.0
#include "apps/reconstruct/photograph_source.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <iterator>
#include <string_view>
#include <system_error>

#include "apps/cli/child_process.h"
#include "apps/reconstruct/folders.h"
#include "kernels/core/check.h"
#include "kernels/core/files.h"

namespace vesta::app {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kPhotographs[] = {".jpg", ".jpeg", ".png", ".webp", ".tif", ".tiff", ".heic", ".heif"};
constexpr std::string_view kFilms[] = {".mp4", ".mov", ".m4v",  ".avi", ".mkv", ".webm",
                                       ".mts", ".3gp", ".m2ts", ".mpg", ".wmv", ".mpeg"};

// In small letters.
std::string ExtensionOf(const fs::path& file) {
  std::string extension = file.extension().string();
  std::ranges::transform(extension, extension.begin(), [](unsigned char c) { return std::tolower(c); });
  return extension;
}

template <std::size_t N>
bool IsOneOf(const fs::path& file, const std::string_view (&extensions)[N]) {
  return std::ranges::find(extensions, ExtensionOf(file)) != std::end(extensions);
}

// COLMAP's lists have one name per line, without the spaces around it.
void CheckName(const std::string& folder, const std::string& name) {
  const bool has_control = std::ranges::any_of(name, [](unsigned char c) { return c < 0x20 || c == 0x7f; });
  if (has_control || Trimmed(name) != name) {
    Fail(kBadArgument, "{}: the name of the photograph {} has a control character, or a space at an end; rename it",
         folder, Printable(name));
  }
}

void ListFolder(PhotographSource* source) {
  constexpr std::size_t kMost = 50'000;
  std::error_code error;
  fs::recursive_directory_iterator it(source->path, error), end;
  for (; !error && it != end; it.increment(error)) {
    std::error_code ignored;
    const bool is_hidden = it->path().filename().string().starts_with('.');
    if (is_hidden && it->is_directory(ignored)) it.disable_recursion_pending();
    if (is_hidden || !it->is_regular_file(ignored)) continue;
    if (!IsOneOf(it->path(), kPhotographs)) {
      ++source->num_others;
      continue;
    }
    source->names.push_back(it->path().lexically_relative(source->path).generic_string());
    CheckName(source->path, source->names.back());
    source->bytes += it->file_size(ignored);
    if (source->names.size() > kMost) {
      Fail(kUnsupported, "{}: more than {} photographs; select the photographs of one scene", source->path, kMost);
    }
  }
  if (error) Fail(kNotFound, "{}: cannot be listed: {}; check its permissions", source->path, error.message());
  std::ranges::sort(source->names);
  if (source->names.size() < kFewestPhotographs) {
    Fail(kBadArgument, "{}: {} photographs (.jpg, .png, .webp, .tif or .heic); a scene needs at least {}, better 20",
         source->path, source->names.size(), kFewestPhotographs);
  }
}

void Link(const fs::path& from, const fs::path& to) {
  std::error_code error;
  fs::create_hard_link(from, to, error);
  if (!error) return;
  // Another file system, or one without hard links.
  fs::copy_file(from, to, error);
  CheckWritten(error, to);
}

// heif-convert adds "-1" to the name if the file has several images, and more files for depth maps.
void ConvertHeic(const std::string& converter, const fs::path& from, const fs::path& to, const fs::path& scratch,
                 const std::string& log) {
  MakeEmptyFolder(scratch);
  RunChildOrFail(fmt::format("the conversion of {}", from.string()),
                 {.words = {converter, "-q", "95", from.string(), "photograph.jpg"}, .log = log, .folder = scratch});
  const bool has_one = FileExists(scratch / "photograph.jpg"), has_first = FileExists(scratch / "photograph-1.jpg");
  if (!has_one && !has_first) {
    Fail(kBadFile, "{}: cannot be converted to JPEG; the messages of {} are in {}", from.string(), converter, log);
  }
  Rename(scratch / (has_one ? "photograph.jpg" : "photograph-1.jpg"), to);
  Remove(scratch);
}

}  // namespace

bool IsHeic(const std::string& name) {
  const std::string extension = ExtensionOf(name);
  return extension == ".heic" || extension == ".heif";
}

PhotographSource FindPhotographs(const std::string& path) {
  std::error_code error;
  const fs::path absolute = fs::canonical(path, error);
  if (error) Fail(kNotFound, "{}: no such file or folder; give a folder of photographs, or a film", path);
  PhotographSource source{.path = absolute.string()};
  if (fs::is_directory(absolute, error)) {
    ListFolder(&source);
    return source;
  }
  if (!IsOneOf(absolute, kFilms)) {
    Fail(kUnsupported, "{}: neither a folder of photographs nor a film (such as .mp4 or .mov)", path);
  }
  source.is_film = true;
  source.bytes = fs::file_size(absolute, error);
  return source;
}

void CollectPhotographs(const PhotographSource& source, const std::string& images, const std::string& work,
                        const std::string& log) {
  std::string converter;
  for (const std::string& name : source.names) {
    const fs::path from = fs::path(source.path) / name, to = fs::path(images) / name;
    MakeFolder(to.parent_path());
    if (!IsHeic(name)) {
      Link(from, to);
      continue;
    }
    if (converter.empty()) converter = FindHeicConverter();
    ConvertHeic(converter, from, to.string() + ".jpg", fs::path(work) / "heic", log);
  }
}

std::string FindHeicConverter() {
  // Later versions of libheif call it heif-dec.
  const bool is_renamed = FindProgram("heif-convert").empty() && !FindProgram("heif-dec").empty();
  return is_renamed ? FindProgram("heif-dec")
                    : RequireProgram("heif-convert", "libheif-examples", "for HEIC photographs");
}

}  // namespace vesta::app
