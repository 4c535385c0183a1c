// SPDX-License-Identifier: Apache-2.0
// Writes videos with the program ffmpeg. Makes file names for the images of views.
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

// Checks the value of --film. Throws Error (one line with --film) if the name does not end in .mp4, if ffmpeg is not
// installed, or if the file cannot be written.
void CheckFilm(const std::string& file);

// A video with ffmpeg's default codec for .mp4 (H.264 in usual builds). The file appears only when Finish is called;
// without it, the destructor ends ffmpeg and discards the video.
class Film {
 public:
  // size: width and height of the frames, pixels. An odd width or height is padded by one black column or row.
  // frames_per_second > 0.
  Film(const std::string& file, gs::ImageSize size, double frames_per_second);
  ~Film();
  Film(const Film&) = delete;
  Film& operator=(const Film&) = delete;

  // Adds a frame; colours are clamped to 0..1. Add and Finish throw Error with ffmpeg's message if ffmpeg has failed.
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

// Returns a unique .png file name for each view. It is View::name without the extension, with "_" for "/". If two names
// would then be equal, all names keep the extension. If some are still equal ("a/b.jpg" and "a_b.jpg"), all but the
// first get a number. files_of(name): the files that will be written for the name, starting with the name itself; each
// must be unique too.
std::vector<std::string> FileNames(const std::vector<const gs::View*>& views,
                                   const std::function<std::vector<std::string>(const std::string&)>& files_of);

}  // namespace vesta::app
