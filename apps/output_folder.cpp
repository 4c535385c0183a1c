#include "apps/output_folder.h"

#include <algorithm>
#include <filesystem>

#include "kernels/core/atomic_file.h"
#include "kernels/core/check.h"

namespace vesta::app {

namespace fs = std::filesystem;

OutputFolder::OutputFolder(const std::string& path) : path_(path) {
  std::error_code error;
  for (fs::path folder = path; !folder.empty() && !fs::exists(folder, error); folder = folder.parent_path()) {
    if (folder.has_filename()) made_.insert(made_.begin(), folder.string());
  }
  fs::create_directories(path, error);
  // create_directories is content with a file that is no directory on some systems.
  if (!error && !fs::is_directory(path)) error = std::make_error_code(std::errc::not_a_directory);
  try {
    if (error) Fail("--out={}: cannot be made: {}; choose a folder you can write", path, error.message());
    const AtomicFile probe(File("metrics.json"));  // makes a temporary file and removes it
  } catch (...) {
    RemoveMade();
    throw;
  }
}

OutputFolder::~OutputFolder() { RemoveMade(); }

void OutputFolder::RemoveMade() {
  std::error_code ignored;  // not empty, or never made: stays
  std::for_each(made_.rbegin(), made_.rend(), [&](const std::string& folder) { fs::remove(folder, ignored); });
}

std::string OutputFolder::File(const std::string& name) const { return (fs::path(path_) / name).string(); }

void CheckWritable(const char* flag, const std::string& file) {
  if (fs::is_directory(file)) Fail("--{}={}: is a folder; name a file", flag, file);
  try {
    const AtomicFile probe(file);  // makes a temporary file and removes it
  } catch (const Error& error) {
    Fail("--{}={}", flag, error.what());  // which begins with the file
  }
}

}  // namespace vesta::app
