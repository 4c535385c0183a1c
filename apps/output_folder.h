// Folders and files for results, checked before the work that fills them.
#pragma once

#include <string>
#include <vector>

namespace vesta::app {

// Makes the folder with its parents and sees that a file can be written in it. Unless Keep is called, the destructor
// removes again the folders made here: a run that fails leaves nothing behind.
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
  void RemoveMade();

  std::string path_;
  std::vector<std::string> made_;  // outermost first
};

// Throws Error, naming the flag, unless a file of that name, its value, can be written.
void CheckWritable(const char* flag, const std::string& file);

}  // namespace vesta::app
