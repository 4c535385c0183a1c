// SPDX-License-Identifier: Apache-2.0
// Names for the images of views, and films, by the program ffmpeg.
#pragma once

#include <sys/types.h>

#include <cstdio>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "kernels/core/files.h"
#include "problems/gaussian_splatting/scene/image.h"
#include "problems/gaussian_splatting/scene/scene.h"

namespace vesta::app {

// Throws Error, one line naming the flag --film, unless the file ends in .mp4 and can be written, and there is ffmpeg.
void CheckFilm(const std::string& file);

// A film while it is written: H.264, or what ffmpeg has in its place. It is there whole, by Finish, or not at all.
class Film {
 public:
  // frames_per_second > 0. Of a size with odd sides one row or column of black is added.
  Film(const std::string& file, gs::ImageSize size, double frames_per_second);
  ~Film();
  Film(const Film&) = delete;
  Film& operator=(const Film&) = delete;

  // A frame of that size; colours are clamped to 0..1. Throws Error with ffmpeg's reason where it has given up.
  void Add(const gs::Image& frame);
  void Finish();

 private:
  void Start(const std::string& program, double frames_per_second);
  // Ends what ffmpeg reads, and waits; its exit status, not 0 where it failed.
  int Wait();
  [[noreturn]] void FailWithReason();

  AtomicFile file_;
  gs::ImageSize size_;
  std::unique_ptr<std::FILE, int (*)(std::FILE*)> complaints_;  // what ffmpeg prints
  int frames_ = -1;                                             // descriptor of the socket that it reads from
  pid_t process_ = -1;
};

// One .png for each view, such that no two files are the same: with extensions where they would be without, and
// numbered where with them too ("a/b.jpg" beside "a_b.jpg"). files_of(name): the files of an image of that name, itself
// the first.
std::vector<std::string> FileNames(const std::vector<const gs::View*>& views,
                                   const std::function<std::vector<std::string>(const std::string&)>& files_of);

}  // namespace vesta::app
