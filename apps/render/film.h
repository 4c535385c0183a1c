// SPDX-License-Identifier: Apache-2.0
// Videos by the program ffmpeg, and file names for images of views.
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

// Checks the file of --film. Throws Error, with a message that names the flag, if the file name does not end in .mp4,
// if ffmpeg is not installed, or if the file cannot be written.
void CheckFilm(const std::string& file);

// A video with ffmpeg's default codec for .mp4 (H.264 in usual builds). Finish creates the file. If Finish was not
// called, the destructor ends ffmpeg and discards the video.
class Film {
 public:
  // size: frame size in pixels. A black column or row is added to an odd width or height. frames_per_second > 0.
  Film(const std::string& file, gs::ImageSize size, double frames_per_second);
  ~Film();
  Film(const Film&) = delete;
  Film& operator=(const Film&) = delete;

  // Colours are clamped to 0..1. Add and Finish throw Error with ffmpeg's message if ffmpeg has failed.
  void Add(const gs::Image& frame);
  void Finish();

 private:
  void Start(const std::string& program, double frames_per_second);
  // Closes ffmpeg's input and waits for it. Returns its exit status, 0 for success.
  int Wait();
  [[noreturn]] void FailWithReason();

  AtomicFile file_;
  gs::ImageSize size_;
  std::unique_ptr<std::FILE, int (*)(std::FILE*)> output_;  // what ffmpeg prints (stdout, stderr)
  int frames_socket_ = -1;                                  // to ffmpeg
  pid_t process_ = -1;
};

// A .png file name for each view: View::name with "_" for "/", and with ".png" instead of its extension.
// files_of(name): all files that the caller will write for this name, beginning with the name itself. No two views get
// the same file. If two views would, all names keep their extension ("a.jpg.png"). If two still would ("a/b.jpg" and
// "a_b.jpg"), the first of them in `views` keeps its name ("a_b.jpg.png"). Each later one gets the first free number
// from 2 on ("a_b.jpg_2.png").
std::vector<std::string> FileNames(const std::vector<const gs::View*>& views,
                                   const std::function<std::vector<std::string>(const std::string&)>& files_of);

}  // namespace vesta::app
