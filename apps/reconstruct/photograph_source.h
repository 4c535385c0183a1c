// SPDX-License-Identifier: Apache-2.0
// The argument PHOTOS: a folder of photographs, or a film.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace vesta::app {

// COLMAP needs two photographs for a first pair, and a third to fix the distance of the next camera.
inline constexpr std::size_t kFewestPhotographs = 3;

struct PhotographSource {
  std::string path;  // absolute, without symbolic links
  bool is_film = false;
  std::vector<std::string> names = {};  // photographs, relative to `path`, sorted; empty for a film
  std::uintmax_t bytes = 0;             // size of all these files, or of the film
  std::size_t num_others = 0;           // files in the folder that are not photographs
};

// Lists the photographs (JPEG, PNG, WebP, TIFF, HEIC by their extensions) in the folder and its subfolders. Hidden
// files and folders are ignored. Throws Error if there is no such file or folder, if the folder has too few photographs
// or more than 50,000, if a name has characters that COLMAP's lists of names cannot have, or if the file is not a film
// (by its extension).
PhotographSource FindPhotographs(const std::string& path);

// By the extension: .heic or .heif.
bool IsHeic(const std::string& name);

// Fills the folder `images`, which must be empty, with the photographs of a source that is not a film. Names stay;
// "a.heic" becomes "a.heic.jpg". The files are hard links, or copies on another file system. `work`: an existing folder
// for temporary files; log: receives the messages of the converter. Throws Error if a file cannot be read or written.
void CollectPhotographs(const PhotographSource& source, const std::string& images, const std::string& work,
                        const std::string& log);

// The program that converts HEIC files. Throws Error with the package to install.
std::string FindHeicConverter();

}  // namespace vesta::app
