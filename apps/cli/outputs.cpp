// SPDX-License-Identifier: Apache-2.0
#include "apps/cli/outputs.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <filesystem>
#include <string_view>

#include "kernels/core/check.h"
#include "kernels/core/files.h"

namespace vesta::app {

namespace fs = std::filesystem;

namespace {

// The path with symbolic links and dots resolved, as far as it exists.
fs::path Canonical(const fs::path& path) {
  std::error_code error;
  fs::path result = fs::weakly_canonical(fs::absolute(path, error), error);
  if (error) result = path.lexically_normal();
  return result.has_filename() ? result : result.parent_path();
}

// The folder that contains the file.
fs::path FolderOf(const fs::path& file) {
  return Canonical(file.has_parent_path() ? file.parent_path() : fs::path("."));
}

bool IsWithin(const fs::path& path, const fs::path& folder) {
  return std::mismatch(folder.begin(), folder.end(), path.begin(), path.end()).first == folder.end();
}

// Also true for hard and symbolic links to the same file.
bool IsSameFile(const std::string& a, const std::string& b) {
  struct stat one = {}, other = {};
  if (::stat(a.c_str(), &one) == 0 && ::stat(b.c_str(), &other) == 0) {
    return one.st_dev == other.st_dev && one.st_ino == other.st_ino;
  }
  return Canonical(a) == Canonical(b);
}

}  // namespace

void RunFiles::Reads(const std::string& file) { read_.push_back(file); }

void RunFiles::ReadsScene(const std::string& folder) {
  scenes_.push_back(Canonical(folder).string());
  for (const char* usual : {"images", "sparse"}) scene_folders_.push_back(Canonical(fs::path(folder) / usual).string());
}

void RunFiles::ReadsScene(const std::string& folder, const gs::Scene& scene) {
  std::vector<std::string> firsts;  // first components of the paths inside the scene
  const auto add = [&](const std::string& file) {
    Reads(file);
    const fs::path inside = fs::path(file).lexically_relative(folder);
    const bool is_below = std::distance(inside.begin(), inside.end()) > 1;
    if (is_below && inside.begin()->string() != "..") firsts.push_back(inside.begin()->string());
  };
  for (const gs::View& view : scene.views) {
    add(view.image_path);
    if (!view.mask_path.empty()) add(view.mask_path);
  }
  for (const std::string& file : scene.files) add(file);
  std::sort(firsts.begin(), firsts.end());
  firsts.erase(std::unique(firsts.begin(), firsts.end()), firsts.end());
  for (const std::string& first : firsts) scene_folders_.push_back(Canonical(fs::path(folder) / first).string());
}

void RunFiles::Writes(const std::string& given, const std::string& file) {
  outputs_.push_back({given, file, Kind::kFile});
}

void RunFiles::WritesInto(const std::string& given, const std::string& folder) {
  outputs_.push_back({given, folder, Kind::kFilesInFolder});
}

void RunFiles::WritesFolder(const std::string& given, const std::string& folder) {
  outputs_.push_back({given, folder, Kind::kFolder});
}

void RunFiles::CheckPlace(const Output& output) const {
  const fs::path folder = output.kind == Kind::kFile ? FolderOf(output.path) : Canonical(output.path);
  const auto holds = [&](const std::string& scene) { return IsWithin(folder, scene); };
  if (std::find(scenes_.begin(), scenes_.end(), folder.string()) != scenes_.end() ||
      std::any_of(scene_folders_.begin(), scene_folders_.end(), holds)) {
    Fail(kBadArgument, "{}: {} is a folder of the scene; choose a folder without files of the scene", output.given,
         folder.string());
  }
}

void RunFiles::CheckFolder(const Output& output) const {
  std::error_code error;
  const fs::file_status status = fs::status(output.path, error);
  if (fs::exists(status) && !fs::is_directory(status)) {
    Fail(kCannotWrite, "{}: {} exists and is not a folder; rename it or choose another folder", output.given,
         output.path);
  }
  for (const std::string& file : read_) {
    if (output.kind != Kind::kFolder || !IsWithin(Canonical(file), Canonical(output.path))) continue;
    Fail(kBadArgument, "{}: the input {} is inside {}, which is overwritten; choose another folder", output.given, file,
         output.path);
  }
}

void RunFiles::CheckFile(const Output& output) const {
  std::error_code error;
  const fs::file_status status = fs::status(output.path, error);
  if (fs::is_directory(status))
    Fail(kCannotWrite, "{}: {} is a folder, not a file; choose another name", output.given, output.path);
  if (fs::exists(status) && !fs::is_regular_file(status)) {
    Fail(kCannotWrite, "{}: {} is not a regular file; choose another name", output.given, output.path);
  }
  for (const std::string& file : read_) {
    if (IsSameFile(file, output.path)) {
      Fail(kBadArgument, "{}: it would overwrite the input {}; choose another name or folder", output.given, file);
    }
  }
  for (const Output& other : outputs_) {
    if (&other == &output) break;
    if (other.kind == Kind::kFile && IsSameFile(other.path, output.path)) {
      Fail(kBadArgument, "{}: it is the same file as {}; choose another name", output.given, other.given);
    }
  }
}

void RunFiles::Check() const {
  for (const Output& output : outputs_) {
    CheckPlace(output);
    output.kind == Kind::kFile ? CheckFile(output) : CheckFolder(output);
  }
}

OutputFolder::OutputFolder(const std::string& path) : path_(path) {
  try {
    Make();
    Lock();
    // For all commands, which may share a folder.
    RemoveAbandonedTemporaries(path, [](const std::string& name) {
      const auto ends = [&](const char* extension) { return name.ends_with(extension); };
      return ends(".ply") || ends(".json") || ends(".html") || ends(".vesta") || ends(".png");
    });
    const AtomicFile probe(File("metrics.json"));  // creates and removes a temporary file
  } catch (...) {
    Release();
    throw;
  }
}

OutputFolder::~OutputFolder() { Release(); }

void OutputFolder::Make() {
  std::error_code error;
  for (fs::path folder = path_; !folder.empty() && !fs::exists(folder, error); folder = folder.parent_path()) {
    if (folder.has_filename()) made_.insert(made_.begin(), folder.string());
  }
  fs::create_directories(path_, error);
  // create_directories may not fail if the path is a file.
  if (!error && !FolderExists(path_)) error = std::make_error_code(std::errc::not_a_directory);
  if (error)
    Fail(kCannotWrite, "--out={}: cannot be created: {}; choose a folder you can write to", path_, error.message());
}

void OutputFolder::Lock() {
  lock_ = ::open(path_.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  // Without locks in the file system, the folder is not locked.
  if (lock_ >= 0 && ::flock(lock_, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) {
    Fail(kCannotWrite, "--out={}: another run writes to this folder; wait until it ends, or choose another folder",
         path_);
  }
}

void OutputFolder::Release() {
  std::error_code ignored;  // a folder that is not empty stays
  std::for_each(made_.rbegin(), made_.rend(), [&](const std::string& folder) { fs::remove(folder, ignored); });
  if (lock_ >= 0) ::close(lock_);
}

std::string OutputFolder::File(const std::string& name) const { return (fs::path(path_) / name).string(); }

RunFiles FilesOf(const CommandLine& line) {
  RunFiles files;
  for (std::size_t i = 0; i < line.arguments.size(); ++i) {
    const bool is_scene = line.command->arguments[i] == std::string_view("SCENE");
    is_scene ? files.ReadsScene(line.arguments[i]) : files.Reads(line.arguments[i]);
  }
  if (!line.flags.config.empty()) files.Reads(line.flags.config);
  return files;
}

std::string FlagText(const char* flag, const std::string& value) { return fmt::format("--{}={}", flag, value); }

void CheckWritable(const char* flag, const std::string& file) {
  if (FolderExists(file)) Fail(kCannotWrite, "{}: this is a folder; give the name of a file", FlagText(flag, file));
  const fs::path path(file);
  const std::string name = path.filename().string();
  RemoveAbandonedTemporaries(FolderOf(path).string(), [&](const std::string& other) { return other == name; });
  try {
    const AtomicFile probe(file);  // creates and removes a temporary file
  } catch (const Error& error) {
    Fail(kCannotWrite, "--{}={}", flag, error.what());  // what() begins with the file name
  }
}

}  // namespace vesta::app
