// SPDX-License-Identifier: Apache-2.0
// Videos, encoded by the program ffmpeg, and file names for the images of views.
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

// Throws Error if the file name does not end in .mp4, if the program ffmpeg is not installed, or if the file cannot be
// written. The message names the option --film.
void CheckFilm(const std::string& file);

// Writes a video with ffmpeg's default codec for .mp4 (H.264 in usual builds). Only Finish creates the file, when the
// video is complete.
class Film {
 public:
  // frames_per_second > 0. An odd width or height is padded by one black column or row.
  Film(const std::string& file, gs::ImageSize size, double frames_per_second);
  ~Film();
  Film(const Film&) = delete;
  Film& operator=(const Film&) = delete;

  // Adds a frame of this size; colours are clamped to 0..1. Throws Error with ffmpeg's message if it has failed.
  void Add(const gs::Image& frame);
  void Finish();

 private:
  void Start(const std::string& program, double frames_per_second);
  // Closes the input of ffmpeg and waits for it. Returns its exit status, 0 for success.
  int Wait();
  [[noreturn]] void FailWithReason();

  AtomicFile file_;
  gs::ImageSize size_;
  std::unique_ptr<std::FILE, int (*)(std::FILE*)> output_;  // output of ffmpeg
  int frames_ = -1;                                         // socket that ffmpeg reads from
  pid_t process_ = -1;
};

// Returns a unique .png name for each view. The extension of the views' names is dropped. If two names would then be
// equal, all names keep it. If some are still equal ("a/b.jpg" and "a_b.jpg"), all but the first get a number.
// files_of(name): all files that are written for an image of this name, the name itself first; none of them may clash.
std::vector<std::string> FileNames(const std::vector<const gs::View*>& views,
                                   const std::function<std::vector<std::string>(const std::string&)>& files_of);

}  // namespace vesta::app
