// SPDX-License-Identifier: Apache-2.0
// Checks of the output paths, made before the work starts. One rule for all commands: an output never overwrites an
// input and is never inside a folder of the scene, and no two outputs are the same file.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "apps/cli/flags.h"
#include "problems/gaussian_splatting/scene/scene.h"

namespace vesta::app {

// The input and output files of a run.
class RunFiles {
 public:
  // An input file. It may be missing: the reader reports that.
  void Reads(const std::string& file);
  // A scene before loading: its folder, images/ and sparse/.
  void ReadsScene(const std::string& folder);
  // A loaded scene: all its files and their folders.
  void ReadsScene(const std::string& folder, const gs::Scene& scene);

  // Writes: an output file. WritesInto: a folder that will receive output files whose names are not known yet. given:
  // the flag for messages, "--out=DIR".
  void Writes(const std::string& given, const std::string& file);
  void WritesInto(const std::string& given, const std::string& folder);
  // A folder that the run owns completely: no input may be in it.
  void WritesFolder(const std::string& given, const std::string& folder);

  // Throws Error (one line that names the flag) if the rule is violated or an output is not a replaceable file.
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
  std::vector<std::string> scenes_, scene_folders_;  // canonical paths; a scene_folder includes its subfolders
  std::vector<Output> outputs_;
};

// Creates the folder and its parents, checks that it is writable, and locks it against other runs. Removes temporary
// files of killed runs. Unless Keep is called, the destructor removes the folders that were created here, so a failed
// run leaves nothing behind.
class OutputFolder {
 public:
  // Throws Error (one line that names the folder).
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

// The inputs of a command: every file and folder in its arguments, and the file of --config.
RunFiles FilesOf(const CommandLine& line);

// "--flag=value".
std::string FlagText(const char* flag, const std::string& value);

// Throws Error if `file` cannot be written. `file` is the value of the flag; the message names the flag. Removes the
// temporary files that killed runs left for this file.
void CheckWritable(const char* flag, const std::string& file);

}  // namespace vesta::app
