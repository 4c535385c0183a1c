// SPDX-License-Identifier: Apache-2.0
// Where results may go, checked before the work that makes them. One rule for all commands: an output never replaces a
// file that the run reads, nor lies in a folder of its scene, and no two outputs are one file.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "apps/cli/flags.h"
#include "problems/gaussian_splatting/scene/scene.h"

namespace vesta::app {

// What a run reads and what it writes.
class RunFiles {
 public:
  // A file that is read. Where it is missing, whoever reads it says so.
  void Reads(const std::string& file);
  // A scene, before it is read: its folder, and where photographs and models lie as a rule.
  void ReadsScene(const std::string& folder);
  // The same once it is read: the folders of all its files.
  void ReadsScene(const std::string& folder, const gs::Scene& scene);

  // A file that is written, and files of names yet unknown; given: the flag that says so, "--out=DIR".
  void Writes(const std::string& given, const std::string& file);
  void WritesInto(const std::string& given, const std::string& folder);
  // A folder whose files are all the run's: nothing that is read may lie in it.
  void WritesFolder(const std::string& given, const std::string& folder);

  // Throws Error, one line naming the flag, where the rule does not hold, or a file cannot be replaced: a folder.
  void Check() const;

 private:
  enum class Kind { kFile, kSomeIn, kFolder };
  struct Output {
    std::string given, path;
    Kind kind;
  };
  void CheckPlace(const Output& output) const;
  void CheckFile(const Output& output) const;
  void CheckFolder(const Output& output) const;

  std::vector<std::string> read_;
  std::vector<std::string> scenes_, scene_folders_;  // canonical: theirs alone, and with all below
  std::vector<Output> outputs_;
};

// Makes the folder with its parents, sees that a file can be written in it, and keeps other runs out of it. What a run
// that was killed has left there half written is removed. Unless Keep is called, the destructor removes again the
// folders made here: a run that fails leaves nothing behind.
class OutputFolder {
 public:
  // Throws Error, one line naming the folder.
  explicit OutputFolder(const std::string& path);
  ~OutputFolder();
  OutputFolder(const OutputFolder&) = delete;
  OutputFolder& operator=(const OutputFolder&) = delete;

  const std::string& path() const { return path_; }
  std::string File(const std::string& name) const;
  void Keep() { made_.clear(); }

 private:
  void Make();
  void Lock();
  void Release();

  std::string path_;
  std::vector<std::string> made_;  // outermost first
  int lock_ = -1;                  // descriptor
};

// What a command with these arguments and flags reads: every file and folder that it names.
RunFiles FilesOf(const CommandLine& line);

// "--flag=value".
std::string Given(const char* flag, const std::string& value);

// Throws Error, naming the flag, unless a file of that name, its value, can be written. Removes what a run that was
// killed has left of it.
void CheckWritable(const char* flag, const std::string& file);

}  // namespace vesta::app
