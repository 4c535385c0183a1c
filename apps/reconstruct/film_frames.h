// SPDX-License-Identifier: Apache-2.0
// Photographs from a film: the program ffmpeg extracts frames, and the sharpest frame of each interval is kept.
#pragma once

#include <optional>
#include <string>

#include "apps/reconstruct/photograph_source.h"

namespace vesta::app {

struct FramePlan {
  int photographs = 0;  // frames to keep, each from an interval of the same length
  int candidates = 0;   // frames to extract
  double rate = 0;      // frames to extract per second
};

// By default three photographs per second, for a camera that moves at walking speed; at least 40, and at most 300,
// because the time of COLMAP and of the training grows with their number. wanted: another number. Never more than the
// frames of the film. Three candidates per photograph if the film has them.
FramePlan PlanFrames(double film_seconds, double film_rate, std::optional<int> wanted);

// Fills the folder `images` with 00001.jpg and so on, in the order of the film, of at most 1600 pixels on the longer
// side. `work`: an existing folder for temporary files. Throws Error if ffmpeg cannot read the film.
void ExtractFrames(const PhotographSource& film, std::optional<int> wanted, const std::string& images,
                   const std::string& work, const std::string& log);

// Throws Error, with the package to install, if ffmpeg or ffprobe is missing.
void CheckFilmPrograms();

}  // namespace vesta::app
