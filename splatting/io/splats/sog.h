// SPDX-License-Identifier: Apache-2.0
// .sog files: the compact format of PlayCanvas (developer.playcanvas.com, "The SOG Format"), version 2. Each Gaussian
// is a pixel in several lossless WebP images, described by meta.json. A bundle is a zip archive of these files.
#pragma once

#include <cmath>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "kernels/core/span.h"
#include "kernels/math/spherical_harmonics.h"
#include "problems/gaussian_splatting/model/splat_model.h"
#include "splatting/io/splats/splat_file.h"

namespace vesta::gs {

// Whether these are the first bytes of a zip archive or of a JSON file.
bool IsSog(std::string_view bytes);

// Reads a bundle, or a meta.json with its images in the same folder. vesta's comments (SplatComments) are read from the
// member "extras". Throws Error, in one line with the file and the problem, if the file is damaged or not supported.
// The number of Gaussians is checked against the sizes of the images before memory is allocated.
SplatModel ReadSog(const std::string& path, std::vector<std::string>* notes = nullptr);
// bytes: the content of the file.
SplatModel ReadSog(const std::string& path, std::string_view bytes, std::vector<std::string>* notes);

// Writes a bundle, completely or not at all (kernels/core/files.h). Reorders the Gaussians so that neighbours are
// adjacent in the images (ChunkOrder). Quantisation steps:
//   means            1/65535 of the bounds of sign(x) log(1 + |x|)
//   log-scales       256 numbers for all axes (palette.h)
//   rotations        sqrt(2) / 255 in the three smaller numbers of the quaternion
//   opacities        1/255 (packed_values.h)
//   SH coefficient 0 256 numbers for all channels
//   the others       a palette: its size is the greatest power of two up to the number of Gaussians, at most 65536. Its
//                    coefficients are 256 numbers.
// Throws Error, with the file, if a value is not finite.
void WriteSog(const std::string& path, const SplatModel& model);

// Shared by the reader and the writer.
namespace sog {

inline constexpr const char* kMetaFile = "meta.json";
inline constexpr int kVersion = 2;
inline constexpr const char* kAntialiased = "antialiased";  // value of "model"
inline constexpr Index kEntriesPerRow = 64;                 // of the SH palette in its image
inline constexpr Index kMostEntries = 1 << 16;              // labels have 16 bits
inline constexpr std::uint8_t kFirstTag = 252;  // alpha of a rotation: this plus the index of the largest of w, x, y, z
inline constexpr double kMeanSteps = 65535;
inline constexpr double kRotationScale = 127.5;  // bytes per 1/sqrt(2), from the centre

inline double LogOfMean(double mean) { return std::copysign(std::log1p(std::abs(mean)), mean); }
inline double MeanOfLog(double log) { return std::copysign(std::expm1(std::abs(log)), log); }

// Number of SH coefficients above degree 0 per channel.
inline Index HigherCoefficients(int degree) { return ShCoefficients(degree) - 1; }

}  // namespace sog

}  // namespace vesta::gs
