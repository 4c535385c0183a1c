// SPDX-License-Identifier: Apache-2.0
// The stages of a reconstruction by COLMAP: features, matches, mapping.
#pragma once

#include <string>
#include <vector>

#include "apps/reconstruct/camera_groups.h"
#include "apps/reconstruct/colmap_program.h"
#include "apps/reconstruct/progress_file.h"

namespace vesta::app {

// Features are computed on images of at most this many pixels on the longer side. COLMAP's own limit is 3,200, with
// four times the pixels.
inline constexpr int kFeaturePixels = 1600;

// Finds the features of all photographs. One run of COLMAP per group, so that each group has one camera. Removes an
// older database: COLMAP would give the remaining photographs of an incomplete group a second camera.
void ExtractFeatures(const ColmapProgram& colmap, const ReconstructionPaths& paths, const GroupedPhotographs& grouped);

// The pairs of photographs to match.
enum class Pairs {
  kAll,           // up to 300 photographs
  kNeighbours,    // photographs that are near each other in the order of their names
  kAndPositions,  // also those whose GPS positions are close
};

// Films are sequences. So are, usually, large sets of photographs: cameras number their files. All pairs of more than
// 300 photographs, 45,000, would take too long. COLMAP's search for similar photographs would need a vocabulary tree,
// which is a download. GPS positions, if at least two photographs have them, connect parts of the sequence (drones).
Pairs ChoosePairs(bool is_film, std::size_t photographs, std::size_t positions);

// Finds the matches. Continues an interrupted run: COLMAP skips the pairs in its database.
void MatchFeatures(const ColmapProgram& colmap, const ReconstructionPaths& paths, Pairs pairs, std::size_t photographs);

// Finds cameras and points; paths.models receives one folder per model. Throws Error, with the log and likely reasons,
// if there is no model.
void MapPhotographs(const ColmapProgram& colmap, const ReconstructionPaths& paths, std::size_t photographs);

}  // namespace vesta::app
