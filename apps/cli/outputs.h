// SPDX-License-Identifier: Apache-2.0
// Checks the output paths before a command starts its work: an output never overwrites an input and is never inside a
// folder of the scene, and no two outputs are the same file.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "apps/cli/flags.h"
#include "problems/gaussian_splatting/scene/scene.h"

namespace vesta::app {

// Input and output paths of a run.
class RunFiles {
 public:
  // The file need not exist.
  void Reads(const std::string& file);
  // A scene that is not loaded yet: the folder itself, its images/ and sparse/.
  void ReadsScene(const std::string& folder);
  // A loaded scene: all its files, and the subfolders of the scene folder that contain them.
  void ReadsScene(const std::string& folder, const gs::Scene& scene);

  // An output file, or a folder for files with names not known yet. given: the flag for messages, such as "--out=DIR".
  void Writes(const std::string& given, const std::string& file);
  void WritesInto(const std::string& given, const std::string& folder);
  // A folder that the run may overwrite completely: it must not contain an input.
  void WritesFolder(const std::string& given, const std::string& folder);

  // Throws Error (one line with the flag) if a rule is violated, or if a folder exists at the path of an output file or
  // a file at the path of an output folder.
  void Check() const;

 private:
  enum class Kind { kFile, kFilesInFolder, kFolder };
  struct Output {
    std::string given, path;
    Kind kind;
  };
  void CheckPlace(const Output& output) const;
  void CheckFile(const Output& output) const;
  void CheckFolder(const Output& output) const;

  std::vector<std::string> read_;
  // Canonical paths. No output may be directly in a folder of scenes_, or at any depth in one of scene_folders_.
  std::vector<std::string> scenes_, scene_folders_;
  std::vector<Output> outputs_;
};

// The output folder of a run. The constructor creates it with its parents, checks that it is writable, locks it against
// other runs, and removes the temporary files that killed runs left in it. The destructor unlocks it. Unless Keep was
// called, it also removes those created folders that are empty.
class OutputFolder {
 public:
  // Throws Error (one line with the folder) if it cannot be created or written, or if another run has locked it.
  explicit OutputFolder(const std::string& path);
  ~OutputFolder();
  OutputFolder(const OutputFolder&) = delete;
  OutputFolder& operator=(const OutputFolder&) = delete;

  const std::string& path() const { return path_; }
  std::string File(const std::string& name) const;
  // Call Keep when the folder contains a result.
  void Keep() { made_.clear(); }

 private:
  void Make();
  void Lock();
  void Release();

  std::string path_;
  std::vector<std::string> made_;  // created folders, outermost first; cleared by Keep
  int lock_ = -1;                  // file descriptor of the locked folder; -1: none
};

// The inputs of a command: files and scenes in its arguments, and the file of --config.
RunFiles FilesOf(const CommandLine& line);

// "--flag=value".
std::string FlagText(const char* flag, const std::string& value);

// file: the value of the flag. Throws Error (one line with the flag) if it cannot be written. Removes the temporary
// files that killed runs left for it.
void CheckWritable(const char* flag, const std::string& file);

}  // namespace vesta::app
